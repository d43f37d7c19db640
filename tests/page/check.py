#!/usr/bin/env python3
"""Checks pages `report.html` in headless Chromium; exit code 1 if one fails.

    check.py [--shots FOLDER] REPORT.html ...

Needs playwright (pip), Chromium (CHROMIUM, default /usr/bin/chromium) and axe-core (npm; AXE, the path of axe.min.js).
"""
import argparse
import os
import pathlib
import sys

from playwright.sync_api import sync_playwright

CHROMIUM = os.environ.get("CHROMIUM", "/usr/bin/chromium")
AXE = pathlib.Path(os.environ.get("AXE", "node_modules/axe-core/axe.min.js"))
MOST_BYTES = 1_000_000
KINDS = ("readings", "residuals", "boundary", "flux")

failures = []


def check(name, good, detail=""):
    print(f"{'ok  ' if good else 'FAIL'} {name}{f': {detail}' if detail != '' else ''}")
    if not good:
        failures.append(name)


class Tab:
    """A page that keeps its errors and requests."""

    def __init__(self, browser, path, width=1400, **options):
        self.context = browser.new_context(viewport={"width": width, "height": 900}, **options)
        self.page = self.context.new_page()
        self.errors, self.requests = [], []
        self.page.on("console", lambda m: self.errors.append(m.text) if m.type in ("error", "warning") else None)
        self.page.on("pageerror", lambda e: self.errors.append(str(e)))
        self.page.on("request", lambda r: self.requests.append(r.url))
        self.page.goto(path.as_uri())
        self.own = path.as_uri()

    def draw_all(self):
        """Scrolls through the page, so that all charts are drawn."""
        self.page.evaluate("""async () => {
            for (let y = 0; y < document.body.scrollHeight; y += 500) {
                scrollTo(0, y);
                await new Promise(done => setTimeout(done, 30));
            }
            scrollTo(0, 0);
            await new Promise(done => setTimeout(done, 100));
        }""")

    def figure(self, kind, sample=0):
        where = "figure[data-plot=pareto]" if kind == "pareto" else f"section[data-sample='{sample}'] figure[data-plot={kind}]"
        return self.page.locator(where)

    def pixels(self, kind):
        self.page.wait_for_timeout(80)
        return self.figure(kind).evaluate("f => [...f.querySelectorAll('canvas')].map(c => c.toDataURL()).join()")

    def close(self, label):
        outside = [u for u in self.requests if not u.startswith(("data:", "blob:")) and u.split("#")[0] != self.own]
        check(f"{label}: no error of a script", not self.errors, self.errors[:3] or "")
        check(f"{label}: nothing is asked of a network", not outside, outside[:3] or "")
        self.context.close()


def layout(browser, path, shots):
    """No violation of accessibility and no overflow, light and dark, on a phone and on a desk."""
    axe = AXE.read_text(encoding="utf-8")
    for scheme in ("light", "dark"):
        for width in (360, 800, 1400):
            tab = Tab(browser, path, width, color_scheme=scheme, bypass_csp=True)  # axe is put in
            label = f"{scheme}, {width} px"
            tab.draw_all()
            drawn, wanted = tab.page.evaluate(
                "[document.querySelectorAll('.charts canvas').length, document.querySelectorAll('.chart').length]")
            check(f"{label}: charts are drawn", drawn == wanted > 0, f"{drawn} of {wanted}")
            check(f"{label}: no overflow", tab.page.evaluate("document.documentElement.scrollWidth") <= width)
            tab.page.evaluate(axe)
            found = tab.page.evaluate("axe.run(document, {resultTypes: ['violations']})")
            bad = [f"{v['id']} ({len(v['nodes'])}): {v['nodes'][0]['target']}" for v in found["violations"]]
            check(f"{label}: accessible", not bad, bad or f"{len(found['passes'])} rules pass")
            if shots:
                tab.page.screenshot(path=shots / f"{path.parent.name}-{scheme}-{width}.png")
                tab.page.screenshot(path=shots / f"{path.parent.name}-{scheme}-{width}-all.png", full_page=width == 1400)
            tab.close(label)


def clicks(browser, path):
    """Choices change what is drawn, the pointer shows values, dragging zooms; by keys too."""
    tab = Tab(browser, path)
    tab.draw_all()

    def changes(label, kind, action):
        before = tab.pixels(kind)
        action()
        check(f"{label} changes {kind}", tab.pixels(kind) != before)

    def radio(kind, place):
        # the label is what is clicked; a radio button may lie under it
        tab.figure(kind).locator("input[type=radio]:not(:checked)").nth(place).check(force=True)

    for kind in KINDS:
        changes("a choice", kind, lambda kind=kind: radio(kind, 0))
    changes("a method", "readings", lambda: tab.figure("readings").locator("input[type=checkbox]").first.click(force=True))
    kinds = KINDS + (("pareto",) if tab.figure("pareto").count() else ())
    for kind in kinds:
        over = tab.figure(kind).locator(".u-over").first
        over.scroll_into_view_if_needed()
        tab.page.wait_for_timeout(150)
        box = over.bounding_box()
        x, y, w = box["x"], box["y"] + 0.5 * box["height"], box["width"]
        tab.page.mouse.move(x + 0.5 * w, y)
        tab.page.wait_for_timeout(80)
        said = tab.figure(kind).locator(".readout").first.inner_text()
        check(f"the pointer shows values in {kind}", any(c.isdigit() for c in said), said.replace("\n", " ")[:80])
        tab.page.mouse.move(2, 2)
        before = tab.pixels(kind)
        tab.page.mouse.move(x + 0.3 * w, y)
        tab.page.mouse.down()
        tab.page.mouse.move(x + 0.6 * w, y, steps=6)
        tab.page.mouse.up()
        tab.page.mouse.move(2, 2)
        check(f"dragging zooms {kind}", tab.pixels(kind) != before)
        tab.page.mouse.dblclick(x + 0.5 * w, y)
        tab.page.mouse.move(2, 2)
        check(f"a double click resets {kind}", tab.pixels(kind) == before)
        chart = tab.figure(kind).locator(".chart").first
        chart.focus()
        tab.page.keyboard.press("ArrowRight")
        first = tab.page.locator("[aria-live]").inner_text()
        check(f"keys say values of {kind}", any(c.isdigit() for c in first), first.replace("\n", " ")[:80])
    tab.page.evaluate("""async () => {
        for (const c of document.querySelectorAll('.toolbar input, .toolbar button, .values summary')) {
            c.click();
            await new Promise(done => setTimeout(done));
        }
    }""")
    tab.close("every control once")


def without_scripts(browser, path):
    """Tables and drawings are there, and nothing that would not work; on paper too."""
    state = """() => ({
        drawn: [...document.querySelectorAll('.static')].filter(e => e.checkVisibility()).length,
        all: document.querySelectorAll('.static').length,
        controls: [...document.querySelectorAll('.toolbar, .chart, .readout')].filter(e => e.checkVisibility()).length,
        empty: [...document.querySelectorAll('figure')].filter(e => e.checkVisibility() && !e.querySelector('svg')).length,
        tables: [...document.querySelectorAll('main table')].filter(e => e.checkVisibility()).length })"""
    tab = Tab(browser, path, 800, java_script_enabled=False)
    found = tab.page.evaluate(state)
    good = found["drawn"] == found["all"] > 0 and found["controls"] == found["empty"] == 0 and found["tables"] > 2
    check("without scripts: tables and drawings", good, found)
    tab.close("without scripts")
    tab = Tab(browser, path, 800, color_scheme="dark")
    tab.draw_all()
    tab.page.emulate_media(media="print", color_scheme="dark")
    found = tab.page.evaluate(state)
    check("on paper: drawings, no controls", found["drawn"] == found["all"] > 0 and found["controls"] == 0, found)
    paper = tab.page.evaluate("getComputedStyle(document.body).backgroundColor")
    check("on paper: white", paper == "rgb(255, 255, 255)", paper)
    tab.close("on paper")


def size(browser, path):
    """Small and soon there. The time is said; what it is on a busy machine is no fault."""
    times = []
    for _ in range(5):
        tab = Tab(browser, path)
        tab.page.wait_for_timeout(300)
        times.append(tab.page.evaluate("performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? 1e9"))
        tab.context.close()
    print(f"     first paint after {sorted(times)[2]:.0f} ms, median of 5")
    size = path.stat().st_size
    check("small", size < MOST_BYTES, f"{size} bytes")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--shots", type=pathlib.Path, help="folder for pictures of the pages")
    parser.add_argument("pages", nargs="+", type=pathlib.Path)
    args = parser.parse_args()
    if args.shots:
        args.shots.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM)
        print("Chromium", browser.version)
        for page in args.pages:
            print(page)
            page = page.resolve()
            size(browser, page)
            without_scripts(browser, page)
            clicks(browser, page)
            layout(browser, page, args.shots)
        browser.close()
    print(f"{len(failures)} checks failed" if failures else "all checks passed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
