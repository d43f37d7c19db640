// Asperity report: replaces the static figures by interactive ones. README.md states the markup contract.
(() => {
  'use strict';

  const source = document.getElementById('report-data');
  if (!source || !window.uPlot) return;
  const samples = JSON.parse(source.textContent).samples;
  // A method keeps its colour and dash on the whole page, and in the pictures beside it: the number of its line.
  const lines = new Map(samples.flatMap(s => s.methods.map(m => [m.label, m.line])));
  const labels = [...lines.keys()];
  const styleOf = label => lines.get(label) ?? labels.indexOf(label);
  const colorOf = style => style % 8, dashOf = style => (style + Math.floor(style / 8)) % 8;
  const Z95 = 1.96, DECADES = 5;

  // ---------------------------------------------------------------- small helpers

  function el(tag, attributes = {}, ...children) {
    const svg = tag === 'svg' || tag === 'line' || tag === 'polygon';
    const node = svg ? document.createElementNS('http://www.w3.org/2000/svg', tag) : document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (typeof value === 'function') node.addEventListener(name, value);
      else if (value != null && value !== false) node.setAttribute(name, value === true ? '' : value);
    }
    node.append(...children);
    return node;
  }

  const isNumber = v => typeof v === 'number' && Number.isFinite(v);
  const superscript = n => String(n).replace(/[-\d]/g, c => c === '-' ? '⁻' : '⁰¹²³⁴⁵⁶⁷⁸⁹'[c]);

  function format(v, digits = 4) {
    if (!isNumber(v)) return '–';
    const size = Math.abs(v);
    if (v === 0 || (size >= 1e-3 && size < 1e5)) return String(+v.toPrecision(digits)).replace('-', '−');
    const [mantissa, exponent] = v.toExponential(digits - 1).split('e');
    const m = +mantissa;
    return (m === 1 ? '' : m + '·').replace('-', '−') + '10' + superscript(+exponent);
  }

  // theta_deg is a list, or {start, step, count} for equal steps.
  const angles = t => Array.isArray(t) ? t : Array.from({ length: t.count }, (_, i) => +(t.start + i * t.step).toFixed(6));
  const largest = lists => lists.flat().reduce((top, v) => isNumber(v) && v > top ? v : top, 0);

  function theme() {
    const css = getComputedStyle(document.documentElement);
    const get = name => css.getPropertyValue('--' + name).trim();
    return {
      get,
      method: k => get('m' + colorOf(k)),
      dash: k => get('d' + dashOf(k)) === 'none' ? undefined : get('d' + dashOf(k)).split(/\s+/).map(Number),
      font: size => `${size}px ${getComputedStyle(document.body).fontFamily}`,
    };
  }

  // Marker shapes, one per method: corners on a circle of radius 1.
  function polygon(corners, turn, inner) { // with inner: a star
    const count = inner ? 2 * corners : corners;
    return Array.from({ length: count }, (_, i) => {
      const r = inner && i % 2 ? inner : 1, angle = (turn + 360 * i / count) * Math.PI / 180;
      return [r * Math.cos(angle), r * Math.sin(angle)];
    });
  }
  const SHAPES = [
    polygon(24, 0), polygon(4, 45), polygon(3, -90), polygon(4, 0), polygon(3, 90), polygon(5, -90, .45), polygon(6, 0), polygon(4, 0, .35),
  ];

  function marker(ctx, shape, x, y, r, fill, stroke) {
    ctx.beginPath();
    for (const [dx, dy] of SHAPES[shape]) ctx.lineTo(x + r * dx, y + r * dy);
    ctx.closePath();
    ctx.fillStyle = fill;
    ctx.fill();
    ctx.strokeStyle = stroke;
    ctx.stroke();
  }

  function swatch(curve) {
    if (curve.kind === 'marks') {
      const points = SHAPES[curve.shape].map(([x, y]) => `${(6 + 5 * x).toFixed(1)},${(6 + 5 * y).toFixed(1)}`).join(' ');
      return el('svg', { class: 'swatch mark', 'aria-hidden': 'true' }, el('polygon', { points, class: `m${colorOf(curve.style)} fill mark` }));
    }
    const line = curve.kind === 'measured' ? { class: 'measured' }
      : { class: 'm' + colorOf(curve.style), style: `stroke-dasharray: var(--d${dashOf(curve.style)})` };
    return el('svg', { class: 'swatch', 'aria-hidden': 'true' }, el('line', { x1: 0, x2: 30, y1: 6, y2: 6, ...line }));
  }

  // ---------------------------------------------------------------- one chart
  // panel: { title, aria, zoom, sync, height, empty, range: [x0, x1], x: {label, log}, y: {label, scale, decades},
  //          curves: [{name, style, shape, kind: 'line'|'measured'|'marks', dash, x, y, low, high, filled, names}],
  //          right, under(u, ctx, theme), over(u, ctx, theme), describe(u), rows() }

  // Puts the curves on their common abscissa; uPlot skips undefined and breaks a line at null.
  function align(curves, log) {
    const x = [...new Set(curves.flatMap(c => c.x))].sort((a, b) => a - b);
    const place = new Map(x.map((v, i) => [v, i]));
    const spread = (curve, values) => {
      const out = new Array(x.length).fill(undefined);
      curve.x.forEach((v, i) => { out[place.get(v)] = isNumber(values[i]) && !(log && values[i] <= 0) ? values[i] : null; });
      return out;
    };
    return { x, spread };
  }

  // The part of the abscissa where a visible amount of light is.
  function litRange(curves, log) {
    const floor = largest(curves.map(c => c.y)) * (log ? 10 ** -DECADES : 1e-3);
    const lit = curves.flatMap(c => c.x.filter((_, i) => c.y[i] >= floor && c.y[i] > 0));
    const all = curves.flatMap(c => c.x);
    const from = Math.min(...all), to = Math.max(...all);
    if (!lit.length || from === to) return [from - 1, to + 1];
    const a = Math.min(...lit), b = Math.max(...lit), pad = Math.max(.05 * (b - a), .01 * (to - from));
    return [Math.max(from, a - pad), Math.min(to, b + pad)];
  }

  function yScale({ scale, decades = DECADES }) {
    const reach = (min, max, least) => Math.max(least, Math.abs(min ?? 0), Math.abs(max ?? 0));
    const even = (min, max, least, room) => [-room * reach(min, max, least), room * reach(min, max, least)];
    switch (scale) {
      case 'log': return { distr: 3, range: (u, min, max) => max > 0 ? [Math.max(min / 1.4, max * 10 ** -decades), max * 1.5] : [1e-3, 1] };
      case 'symlog': return { distr: 4, asinh: 2, range: (u, min, max) => even(min, max, 3, 1.3) };
      case 'symmetric': return { range: (u, min, max) => even(min, max, 1e-6, 1.1) };
      default: return { range: (u, min, max) => max > 0 ? [Math.min(0, min), max * 1.06] : [0, 1] };
    }
  }

  // Grid lines at 1 to 9 times a power of ten, as many labels as there is room for; even steps in a short range.
  const logTicks = {
    splits: (u, i, min, max) => {
      const ticks = [];
      for (let e = Math.floor(Math.log10(min)); 10 ** e <= max; e++) for (let m = 1; m < 10; m++) ticks.push(+`${m}e${e}`);
      const inside = ticks.filter(v => v >= min && v <= max);
      if (inside.length > 3) return inside;
      const raw = (max - min) / 4, unit = 10 ** Math.floor(Math.log10(raw)), step = unit * [1, 2, 5, 10].find(m => m * unit >= raw);
      return Array.from({ length: 6 }, (_, k) => +((Math.ceil(min / step) + k) * step).toPrecision(6)).filter(v => v <= max);
    },
    filter: (u, ticks) => {
      const decades = Math.log10(ticks.at(-1) / ticks[0]), every = Math.ceil(decades / 7);
      if (decades < .5) return ticks;
      return ticks.map(v => {
        const [m, e] = v.toExponential().split('e');
        return (m === '1' && e % every === 0) || (decades < 2.5 && (m === '2' || m === '5')) ? v : null;
      });
    },
  };
  const symlogTicks = {
    splits: (u, i, min, max) => [1, 3, 10, 30, 100, 300, 1e3, 1e4, 1e5, 1e6, 1e7].filter(v => v < max && (max < 300 ? v !== 1 : /^1/.test(v) && v > 1))
      .reduce((ticks, v) => [-v, ...ticks, v], [0]),
    filter: (u, ticks) => ticks,
  };

  function draw(box, panel, view, onCursor, onZoom, onReset) {
    const t = theme(), log = panel.y.scale === 'log';
    const { x, spread } = align(panel.curves, log);
    const data = [x], series = [{}], bands = [];
    for (const c of panel.curves) {
      const color = c.kind === 'measured' ? t.get('measured') : t.method(c.style);
      c.at = data.length;
      data.push(spread(c, c.y));
      series.push({
        label: c.name, stroke: c.kind === 'measured' ? color + '80' : color, spanGaps: false,
        width: c.kind === 'measured' ? 5 : c.names ? 0 : 1.8, dash: c.kind === 'measured' ? undefined : c.dash ?? t.dash(c.style),
        points: c.kind === 'measured' ? { show: true, space: 0, size: 3, width: 0, fill: color } : { show: false },
      });
      if (!c.high || c.kind === 'marks') continue;
      const lift = c.low.map((v, i) => log && isNumber(c.y[i]) ? Math.max(v, c.y[i] * 1e-6) : v);
      for (const edge of [c.high, lift]) {
        data.push(spread(c, edge));
        series.push({ stroke: color + '66', width: .5, auto: false, points: { show: false } });
      }
      bands.push({ series: [data.length - 2, data.length - 1], fill: color + '2e' });
    }
    const axis = (label, size, extra) => ({
      label, size, labelSize: 20, labelGap: 2, labelFont: t.font(12), font: t.font(12), stroke: t.get('muted'), gap: 4,
      grid: { stroke: t.get('grid'), width: 1 }, ticks: { stroke: t.get('line'), width: 1, size: 4 },
      values: (u, splits) => splits.map(v => v == null ? '' : format(v, 5)), ...extra,
    });
    const ratio = devicePixelRatio || 1;
    const clipped = (u, paint) => {
      u.ctx.save();
      u.ctx.beginPath();
      u.ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
      u.ctx.clip();
      u.ctx.setLineDash([]);
      paint();
      u.ctx.restore();
    };
    const marks = u => panel.curves.filter(c => c.kind === 'marks').forEach(c => {
      const color = t.method(c.style), ctx = u.ctx;
      ctx.lineWidth = 1.5 * ratio;
      c.x.forEach((v, i) => {
        if (!isNumber(c.y[i]) || (log && c.y[i] <= 0)) return;
        const px = u.valToPos(v, 'x', true), py = u.valToPos(c.y[i], 'y', true);
        ctx.strokeStyle = color;
        if (c.high && isNumber(c.high[i])) {
          const top = u.valToPos(c.high[i], 'y', true), end = u.valToPos(Math.max(c.low[i], log ? c.y[i] * 1e-6 : -Infinity), 'y', true), w = 4 * ratio;
          ctx.beginPath();
          for (const [x0, y0, x1, y1] of [[px, top, px, end], [px - w, top, px + w, top], [px - w, end, px + w, end]]) { ctx.moveTo(x0, y0); ctx.lineTo(x1, y1); }
          ctx.stroke();
        }
        marker(ctx, c.shape, px, py, 5 * ratio, !c.filled || c.filled[i] ? color : t.get('paper'), color);
      });
    });
    const chart = new uPlot({
      width: Math.max(box.clientWidth, 120), height: panel.height, padding: [8, panel.right ?? 10, 0, 0], legend: { show: false },
      cursor: {
        drag: { x: true, y: false, setScale: false, dist: 5 }, hover: { skip: [null, undefined] },
        points: { size: panel.describe ? 0 : 7, fill: (u, i) => t.get('paper'), width: 2, stroke: (u, i) => series[i].stroke },
        bind: { dblclick: () => () => { onReset(); return null; } },
        sync: panel.sync ? { key: panel.sync, setSeries: false, filters: { pub: type => type === 'mousemove' || type === 'mouseleave' } } : undefined,
      },
      scales: { x: { time: false, distr: panel.x.log ? 3 : 1, range: () => view ?? panel.range }, y: yScale(panel.y) },
      axes: [
        axis(panel.x.label, 26, panel.x.log ? logTicks : { space: 45 }),
        axis(panel.y.label, 50, log ? logTicks : panel.y.scale === 'symlog' ? symlogTicks : { space: 32 }),
      ],
      series, bands,
      hooks: {
        drawAxes: [u => panel.under && clipped(u, () => panel.under(u, u.ctx, t, ratio))],
        draw: [u => { clipped(u, () => marks(u)); if (panel.over) panel.over(u, u.ctx, t, ratio); }],
        setCursor: [onCursor],
        setSelect: [u => {
          if (u.select.width < 5) return;
          const edges = [u.select.left, u.select.left + u.select.width].map(v => u.posToVal(v, 'x'));
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          setTimeout(() => onZoom(edges));
        }],
      },
    }, data, box);
    return chart;
  }

  // ---------------------------------------------------------------- one figure: toolbar, charts, readout, table of values

  const live = el('div', { class: 'hidden', role: 'status', 'aria-live': 'polite' });
  const plots = [];
  const HINT = 'Drag to zoom. Keys: ← → + − 0';

  class Plot {
    constructor(figure, model, spec, controls, legend = []) {
      Object.assign(this, { figure, model, spec, charts: [], boxes: [], readouts: [], at: [], built: false });
      this.area = el('div', { class: 'charts' });
      this.table = el('div', { class: 'table', tabindex: 0, role: 'region', 'aria-label': `Values of the plot: ${model.title}, ${figure.dataset.plot}` });
      this.details = el('details', { class: 'values', toggle: () => this.fillTable() }, el('summary', {}, 'Show values'), this.table);
      const reset = el('button', { type: 'button', 'aria-label': 'Reset zoom', click: () => this.reset() }, 'Reset');
      this.toolbar = el('div', { class: 'toolbar', role: 'group', 'aria-label': `Controls: ${model.title}, ${figure.dataset.plot}` }, ...controls, reset, ...legend);
      this.panels = spec();
      this.area.dataset.panels = this.panels.length;
      this.panels.forEach((panel, i) => this.addBox(panel, i));
      figure.prepend(this.toolbar, this.area, this.details);
      figure.classList.add('live');
      model.plots.push(this);
      plots.push(this);
    }

    addBox(panel, i) {
      const box = el('div', { class: 'chart', role: 'img', tabindex: 0, 'aria-label': panel.aria, keydown: e => this.key(e, i), mousemove: () => { this.at[i] = null; } });
      box.style.minHeight = panel.height + (panel.title ? 20 : 0) + 'px';
      const readout = el('div', { class: 'readout', 'aria-hidden': 'true' });
      this.boxes.push(box);
      this.readouts.push(readout);
      this.area.append(el('div', {}, box, readout));
    }

    build() {
      if (this.built) return;
      this.built = true;
      try {
        this.render();
      } catch (error) { // Keep the static figure when a chart fails.
        [this.toolbar, this.area, this.details].forEach(node => node.remove());
        this.figure.classList.remove('live');
        throw error;
      }
    }

    render() {
      if (!this.built) return;
      this.charts.forEach(u => u && u.destroy());
      this.panels = this.spec();
      this.charts = this.panels.map((panel, i) => {
        const box = this.boxes[i];
        box.replaceChildren();
        box.setAttribute('aria-label', panel.aria);
        this.hint(i);
        if (panel.title) box.append(el('h4', { 'aria-hidden': 'true' }, panel.title));
        if (panel.curves.some(c => c.y.some(isNumber))) {
          return draw(box, panel, this.model.view[panel.zoom], u => this.cursor(u, i), range => this.zoom(i, range), () => this.reset());
        }
        box.append(el('p', { class: 'empty' }, panel.empty));
        box.lastChild.style.height = panel.height + 'px';
        return null;
      });
      this.fillTable();
    }

    resize() {
      this.charts.forEach((u, i) => {
        const width = this.boxes[i].clientWidth;
        if (u && width && width !== u.width) u.setSize({ width, height: u.height });
      });
    }

    zoom(i, range) {
      this.model.view[this.panels[i].zoom] = range;
      this.model.render();
    }

    reset() {
      this.panels.forEach(panel => delete this.model.view[panel.zoom]);
      this.model.render();
    }

    // Values under the cursor: [text of the abscissa, [curve, value], ...].
    values(u, i) {
      const panel = this.panels[i], at = u.cursor.idx;
      if (at == null || u.cursor.left < 0) return null;
      if (panel.describe) return panel.describe(u);
      const rows = panel.curves.map(c => [c, u.data[c.at][u.cursor.idxs[c.at] ?? at]]).filter(([, v]) => isNumber(v));
      return [`${panel.x.short} ${format(u.data[0][at])}${panel.x.unit}`, ...rows];
    }

    cursor(u, i) {
      const rows = this.values(u, i), out = this.readouts[i];
      if (!rows) return this.hint(i);
      out.replaceChildren(el('b', {}, rows[0]), ...rows.slice(1).map(([c, v]) => el('span', {}, swatch(c), c.name + ' ', el('b', {}, format(v)))));
      out.style.minHeight = out.offsetHeight + 'px'; // Grows only, so that the page below stays still.
    }

    hint(i) {
      this.readouts[i].replaceChildren(el('i', {}, i ? '' : HINT));
    }

    key(event, i) {
      const u = this.charts[i], step = event.shiftKey ? 10 : 1;
      if (!u || event.ctrlKey || event.metaKey || event.altKey) return;
      const { min, max } = u.scales.x, x = u.data[0];
      const inside = x.map((v, k) => k).filter(k => x[k] >= min && x[k] <= max);
      if (!inside.length) return;
      let place = inside.indexOf(u.cursor.left >= 0 ? this.at[i] ?? u.cursor.idx : -1);
      const move = { ArrowLeft: -step, ArrowRight: step, Home: -1e9, End: 1e9 }[event.key];
      if (move) place = place < 0 ? inside.length >> 1 : Math.min(Math.max(place + move, 0), inside.length - 1);
      else if (event.key === '+' || event.key === '=' || event.key === '-') {
        const log = this.panels[i].x.log, [f, g] = log ? [Math.log, Math.exp] : [v => v, v => v];
        const center = f(place < 0 ? g((f(min) + f(max)) / 2) : x[inside[place]]), half = (f(max) - f(min)) * (event.key === '-' ? 1 : .25);
        const [from, to] = this.panels[i].range;
        if (event.key !== '-' && max - min < 1e-3 * (to - from)) return;
        this.zoom(i, [Math.max(g(center - half), from), Math.min(g(center + half), to)]);
        live.textContent = `Shown range: ${this.model.view[this.panels[i].zoom].map(v => format(v)).join(' to ')}`;
      } else if (event.key === '0' || event.key === 'Escape') this.reset();
      else return;
      event.preventDefault();
      if (!move) return;
      this.at[i] = inside[place];
      this.model.plots.forEach(p => p.pointAt(this.panels[i], x[this.at[i]], p === this && i));
      live.textContent = [...this.readouts[i].children].map(e => e.textContent).join(', ');
    }

    // Moves the cursor to the abscissa x in one panel, or in those that share its cursor.
    pointAt(panel, x, index) {
      this.charts.forEach((u, i) => {
        if (!u || !(index === i || (panel.sync && this.panels[i].sync === panel.sync))) return;
        const at = u.data[0].indexOf(x), y = this.panels[i].curves.map(c => u.data[c.at][at]).find(isNumber);
        u.setCursor({ left: u.valToPos(x, 'x'), top: isNumber(y) ? Math.max(u.valToPos(y, 'y'), 0) : 0 });
      });
    }

    fillTable() {
      if (!this.details.open || !this.built) return;
      this.table.replaceChildren(...this.panels.map(panel => {
        if (panel.rows) return table(panel.title, ...panel.rows());
        const columns = panel.curves.flatMap(c => c.high ? [[c.name, c.y], ['95 % from', c.low], ['to', c.high]].map(([n, v]) => [n, c, v]) : [[c.name, c, c.y]]);
        const { x, spread } = align(panel.curves, false), lists = columns.map(([, c, v]) => spread(c, v));
        return table(panel.title, [panel.x.label, ...columns.map(c => c[0])], x.map((v, k) => [format(v), ...lists.map(l => l[k] === undefined ? '' : format(l[k]))]));
      }));
    }
  }

  function table(caption, head, rows) {
    const row = (cells, tag) => el('tr', {}, ...cells.map(c => el(tag, { class: 'n', scope: tag === 'th' ? 'col' : null }, c)));
    return el('table', {}, ...(caption ? [el('caption', {}, caption)] : []), el('thead', {}, row(head, 'th')), el('tbody', {}, ...rows.map(r => row(r, 'td'))));
  }

  // ---------------------------------------------------------------- controls; all write to model.state and follow it

  class Model {
    constructor(id, title, state) {
      Object.assign(this, { id, title, state, view: {}, plots: [], followers: [] });
    }

    set(key, value, resets = []) {
      this.state[key] = value;
      resets.forEach(zoom => delete this.view[zoom]);
      this.followers.forEach(follow => follow());
      this.render();
    }

    render() {
      this.plots.forEach(p => p.render());
    }

    // One of a few: radio buttons; one of many: a select.
    choice(legend, key, options, resets) {
      if (options.length > 7) return this.select(legend, key, options, resets);
      const group = `${this.id}-${key}-${this.followers.length}`;
      const inputs = options.map(([value]) => el('input', { type: 'radio', name: group, change: () => this.set(key, value, resets) }));
      const follow = () => inputs.forEach((input, i) => { input.checked = options[i][0] === this.state[key]; });
      this.followers.push(follow);
      follow();
      return el('fieldset', {}, el('legend', {}, legend), ...inputs.map((input, i) => el('label', { class: 'segment' }, input, el('span', {}, options[i][1]))));
    }

    select(legend, key, options, resets) {
      const select = el('select', { change: () => this.set(key, options[select.selectedIndex][0], resets) }, ...options.map(([, text]) => el('option', {}, text)));
      const follow = () => { select.selectedIndex = options.findIndex(o => o[0] === this.state[key]); };
      this.followers.push(follow);
      follow();
      return el('label', { class: 'select' }, legend, select);
    }

    // The legend: one checkbox per method. entries: [[key, curve, note]].
    legend(key, entries) {
      const inputs = entries.map(([id]) => el('input', {
        type: 'checkbox',
        change: event => { const set = new Set(this.state[key]); event.target.checked ? set.add(id) : set.delete(id); this.set(key, set); },
      }));
      const follow = () => inputs.forEach((input, i) => { input.checked = this.state[key].has(entries[i][0]); });
      this.followers.push(follow);
      follow();
      return el('fieldset', { class: 'legend' }, el('legend', {}, 'Methods'), ...entries.map(([, curve, note], i) =>
        el('label', { class: 'key' }, inputs[i], swatch(curve), curve.name, ...(note ? [el('small', {}, note)] : []))));
    }
  }

  const SCALE = [['linear', 'linear'], ['log', 'log']];
  const range = values => { const v = values.filter(isNumber); return v.length ? `${format(Math.min(...v), 3)} to ${format(Math.max(...v), 3)}` : 'no values'; };
  const describe = (title, what, curves, quantity, [a, b]) =>
    `${title}: ${what}. Horizontal ${format(a, 3)} to ${format(b, 3)}. ${quantity}: ${curves.map(c => `${c.name} ${range(c.y)}`).join(', ') || 'no curve chosen'}.`;

  // ---------------------------------------------------------------- the plots of one sample

  function sampleModel(sample, index, section) {
    const rank = sample.methods.map((m, k) => k).sort((a, b) => (sample.methods[a].error_percent ?? Infinity) - (sample.methods[b].error_percent ?? Infinity));
    const accepted = rank.filter(k => sample.methods[k].accepted);
    const fluxOf = k => sample.fluxes?.[k] ?? [], boundaryOf = k => sample.boundary?.[k] ?? [];
    const all = sample.methods.map((m, k) => k);
    const sides = read => ['air', 'inside'].filter(side => all.some(k => read(k).some(r => r.side === side)));
    const boundaryAngles = [...new Set(all.flatMap(k => boundaryOf(k).map(b => b.incidence_deg)))].sort((a, b) => a - b);
    const boundarySides = sides(boundaryOf), fluxSides = sides(fluxOf);
    const model = new Model('s' + index, sample.title, {
      incidence: 0, methods: new Set(accepted.length > 1 ? accepted : rank.slice(0, 2)), readingScale: 'linear', residualScale: sample.incidences.some(inc => inc.noise > 0) ? 'symlog' : 'linear',
      side: boundarySides[0], boundaryIncidence: boundaryAngles[0], boundaryScale: 'log',
      fluxSide: fluxSides[0], fluxMethod: rank.find(k => fluxOf(k).length), fluxScale: 'linear',
    });
    const s = model.state;
    const line = k => ({ name: sample.methods[k].label, style: styleOf(sample.methods[k].label), kind: 'line' });
    const error = m => isNumber(m.error_percent) ? `${format(m.error_percent, 3)} %` : '';
    const methods = read => {
      const entries = all.filter(read).map(k => [k, line(k), error(sample.methods[k])]);
      return entries.length ? [model.legend('methods', entries)] : [];
    };
    const theta = { label: sample.theta_label, short: 'θ', unit: '°' };
    const sideText = { air: 'from air', inside: 'from inside' };
    const sideOptions = list => list.map(side => [side, side]);
    const degrees = v => format(v) + '°';

    const scan = () => {
      const inc = sample.incidences[s.incidence], x = angles(inc.theta_deg);
      const fits = all.filter(k => s.methods.has(k) && inc.fits[k]).map(k => ({ ...line(k), x, y: inc.fits[k] }));
      const measured = { name: 'measured', kind: 'measured', x, y: inc.measured };
      return { inc, fits, measured, range: litRange([measured, ...fits], s.readingScale === 'log'), what: `at incidence ${degrees(inc.sigma_deg)}` };
    };

    const readings = () => {
      const { inc, fits, measured, range, what } = scan(), curves = [measured, ...fits];
      return [{
        zoom: 'scan', sync: model.id, height: 290, range, curves, empty: 'No readings.', x: theta, y: { label: sample.quantity, scale: s.readingScale },
        aria: describe(sample.title, 'readings and fits ' + what, curves, sample.quantity, range),
        under: (u, ctx, t, ratio) => { // The noise of a reading, where the scale shows it.
          if (s.readingScale !== 'log' || !isNumber(inc.noise) || inc.noise < u.scales.y.min) return;
          const y = u.valToPos(inc.noise, 'y', true);
          ctx.fillStyle = t.get('line') + '60';
          ctx.fillRect(u.bbox.left, y, u.bbox.width, u.bbox.height);
          ctx.fillStyle = t.get('muted');
          ctx.font = t.font(11 * ratio);
          ctx.textAlign = 'right';
          ctx.fillText('below the noise', u.bbox.left + u.bbox.width - 6 * ratio, u.bbox.top + u.bbox.height - 6 * ratio);
        },
      }];
    };

    const residuals = () => {
      const { inc, fits, range, what } = scan(), known = isNumber(inc.noise) && inc.noise > 0;
      const unit = known ? inc.noise : largest([inc.measured]) / 100 || 1;
      const curves = fits.map(c => ({ ...c, y: c.y.map((v, i) => isNumber(v) && isNumber(inc.measured[i]) ? (v - inc.measured[i]) / unit : null) }));
      const quantity = known ? '(fit − measured) / noise' : 'fit − measured (% of largest)';
      return [{
        zoom: 'scan', sync: model.id, height: 230, range, curves, empty: 'No fit of the chosen methods here.', x: theta,
        y: { label: quantity, scale: s.residualScale === 'linear' ? 'symmetric' : 'symlog' },
        aria: describe(sample.title, 'residuals ' + what, curves, quantity, range),
        under: (u, ctx, t) => { // Two standard deviations: a right method stays in this band.
          const top = u.valToPos(known ? 2 : 0, 'y', true), end = u.valToPos(known ? -2 : 0, 'y', true);
          ctx.fillStyle = t.get('line') + '80';
          ctx.fillRect(u.bbox.left, top, u.bbox.width, Math.max(end - top, 1));
        },
      }];
    };

    const boundary = () => [['reflection', 'Reflected'], ['transmission', 'Transmitted']].map(([lobe, title]) => {
      const curves = all.filter(k => s.methods.has(k)).flatMap(k => boundaryOf(k)
        .filter(b => b.lobe === lobe && b.side === s.side && b.incidence_deg === s.boundaryIncidence)
        .map(b => {
          const edge = sign => b.std ? b.f.map((f, i) => isNumber(f) && isNumber(b.std[i]) ? Math.max(0, f + sign * Z95 * b.std[i]) : null) : undefined;
          return { ...line(k), x: angles(b.theta_deg), y: b.f, low: edge(-1), high: edge(1) };
        }));
      const range = litRange(curves, s.boundaryScale === 'log');
      return {
        title, zoom: lobe, height: 270, range, curves, empty: 'No prediction of the chosen methods here.', x: { ...theta, label: 'theta (°)' },
        y: { label: 'BSDF (1/sr)', scale: s.boundaryScale },
        aria: describe(sample.title, `BSDF of the boundary ${sideText[s.side]} at incidence ${degrees(s.boundaryIncidence)}, ${title.toLowerCase()} light`, curves, 'BSDF in 1/sr', range),
      };
    });

    const flux = () => {
      const rows = fluxOf(s.fluxMethod).filter(r => r.side === s.fluxSide).sort((a, b) => a.incidence_deg - b.incidence_deg);
      const x = rows.map(r => r.incidence_deg), { name, style } = line(s.fluxMethod);
      const edge = (key, sign) => rows.some(r => isNumber(r['std_' + key])) ? rows.map(r => isNumber(r['std_' + key]) ? Math.max(0, r[key] + sign * Z95 * r['std_' + key]) : null) : undefined;
      const curve = (name, key, shape, dash) => ({ name, style, kind: 'marks', shape, dash, x, y: rows.map(r => r[key]), low: edge(key, -1), high: edge(key, 1) });
      const curves = [curve('transmitted', 'transmitted', 0, []), curve('reflected', 'reflected', 1, [8, 4]), curve('lost', 'lost', 2, [2, 3])];
      const span = x.length > 1 ? [x[0] - .03 * (x.at(-1) - x[0]), x.at(-1) + .03 * (x.at(-1) - x[0])] : [-1, 90];
      return [{
        zoom: 'flux', height: 230, range: span, curves, right: 80, empty: 'No prediction of this method from this side.',
        x: { label: 'angle of incidence (°)', short: 'incidence', unit: '°' }, y: { label: 'fraction of the light', scale: s.fluxScale },
        aria: describe(sample.title, `reflected, transmitted and lost light by ${name}, ${sideText[s.fluxSide]}`, curves, 'Fraction of the incident light', span),
        over: (u, ctx, t, ratio) => { // Names at the right ends, moved apart when they meet.
          const ends = curves.map(c => [c.name, c.y.findLast(v => isNumber(v) && (s.fluxScale === 'linear' || v > 0))]).filter(e => isNumber(e[1]))
            .map(([name, v]) => [name, Math.min(Math.max(u.valToPos(v, 'y', true), u.bbox.top), u.bbox.top + u.bbox.height)]).sort((a, b) => b[1] - a[1]);
          ctx.fillStyle = t.get('ink');
          ctx.font = t.font(12 * ratio);
          ctx.textAlign = 'left';
          let below = Infinity;
          for (const [name, y] of ends) {
            below = Math.min(y, below - 14 * ratio);
            ctx.fillText(name, u.bbox.left + u.bbox.width + 8 * ratio, below + 4 * ratio);
          }
        },
      }];
    };

    const incidence = (key, options, resets) => model.choice('Incidence', key, options, resets);
    const plans = {
      readings: sample.incidences.length && (() => [readings, [
        incidence('incidence', sample.incidences.map((inc, i) => [i, degrees(inc.sigma_deg)]), ['scan']),
        model.choice('Scale', 'readingScale', SCALE)], methods(k => sample.incidences.some(inc => inc.fits[k]))]),
      residuals: sample.incidences.length && (() => [residuals, [
        incidence('incidence', sample.incidences.map((inc, i) => [i, degrees(inc.sigma_deg)]), ['scan']),
        model.choice('Scale', 'residualScale', [['linear', 'linear'], ['symlog', 'log beyond ±2']])]]),
      boundary: boundarySides.length && (() => [boundary, [
        model.choice('From', 'side', sideOptions(boundarySides), ['reflection', 'transmission']),
        incidence('boundaryIncidence', boundaryAngles.map(v => [v, degrees(v)]), ['reflection', 'transmission']),
        model.choice('Scale', 'boundaryScale', SCALE)], methods(k => boundaryOf(k).length)]),
      flux: fluxSides.length && (() => [flux, [
        model.select('Method', 'fluxMethod', all.filter(k => fluxOf(k).length).map(k => [k, sample.methods[k].label])),
        model.choice('From', 'fluxSide', sideOptions(fluxSides), ['flux']), model.choice('Scale', 'fluxScale', SCALE)]]),
    };
    for (const figure of section.querySelectorAll('figure.plot')) {
      const plan = plans[figure.dataset.plot];
      if (plan) new Plot(figure, model, ...plan()); // Nothing to plot: the static part, if any, stays.
    }
  }

  // ---------------------------------------------------------------- error over time, all samples

  function pareto(figure) {
    const model = new Model('pareto', 'All samples', { sample: samples.length > 1 ? -1 : 0, methods: new Set(labels) });
    const s = model.state;
    const curveOf = label => ({ name: label, style: styleOf(label), shape: dashOf(styleOf(label)), kind: 'marks' });
    const spec = () => {
      const chosen = samples.filter((_, i) => s.sample < 0 || s.sample === i), seen = new Set();
      const points = chosen.flatMap(sample => sample.methods.filter(m => isNumber(m.error_percent) && isNumber(m.seconds) && m.error_percent > 0).map(m => {
        let x = Math.max(m.seconds, 1e-4); // The log axis starts at 0.1 ms; points of equal time need distinct abscissas.
        while (seen.has(x)) x *= 1 + 1e-9;
        seen.add(x);
        return { ...m, x, y: m.error_percent, sample: sample.title };
      })).sort((a, b) => a.x - b.x);
      const fronts = chosen.map(sample => {
        let best = Infinity;
        return points.filter(p => p.sample === sample.title && p.y < best && (best = p.y));
      });
      fronts.flat().forEach(p => { p.front = true; });
      const curves = labels.filter(label => s.methods.has(label)).map(label => {
        const own = points.filter(p => p.label === label);
        return { ...curveOf(label), x: own.map(p => p.x), y: own.map(p => p.y), filled: own.map(p => p.accepted), names: own };
      });
      const shown = curves.flatMap(c => c.names), times = points.map(p => p.x), span = [Math.min(...times) / 1.5, Math.max(...times) * 1.7];
      const nearest = u => {
        const far = p => Math.hypot(u.valToPos(p.x, 'x') - u.cursor.left, u.valToPos(p.y, 'y') - u.cursor.top);
        return shown.reduce((best, p) => far(p) < far(best) ? p : best);
      };
      return [{
        zoom: 'pareto', height: 340, range: span, curves, empty: 'No method chosen.', right: 24,
        x: { label: 'time (s)', log: true }, y: { label: 'error (%)', scale: 'log', decades: 12 },
        aria: `Error in percent over computing time in seconds, both logarithmic, ${shown.length} points. On the Pareto front: ` +
          shown.filter(p => p.front).map(p => `${p.sample} ${p.label}`).join(', ') + '.',
        describe: u => {
          const p = nearest(u);
          const text = [`error ${format(p.y, 3)} %`, `${format(p.seconds, 3)} s`, p.grade, p.front && 'on the Pareto front'].filter(Boolean).join(', ');
          return [`${p.sample}, ${p.label}: ${text}`];
        },
        rows: () => [['sample', 'method', 'time (s)', 'error (%)', 'Pareto front'], shown.map(p => [p.sample, p.label, format(p.seconds), format(p.y), p.front ? 'yes' : ''])],
        under: (u, ctx, t, ratio) => {
          ctx.strokeStyle = t.get('measured');
          ctx.lineWidth = (chosen.length > 1 ? 1 : 2) * ratio;
          for (const front of fronts) {
            ctx.beginPath();
            for (const p of front.filter(p => s.methods.has(p.label))) ctx.lineTo(u.valToPos(p.x, 'x', true), u.valToPos(p.y, 'y', true));
            ctx.stroke();
          }
        },
        over: (u, ctx, t, ratio) => { // Labels that meet no other label or point, the front first: methods of one sample, or the end of each front.
          ctx.font = t.font(11.5 * ratio);
          ctx.textAlign = 'left';
          const at = p => [u.valToPos(p.x, 'x', true), u.valToPos(p.y, 'y', true)];
          const ends = fronts.map(front => front.findLast(p => s.methods.has(p.label)));
          const taken = shown.map(p => { const [x, y] = at(p); return [x - 6 * ratio, y - 6 * ratio, x + 6 * ratio, y + 6 * ratio]; });
          const { left, top, width, height } = u.bbox;
          for (const p of [...shown].sort((a, b) => !!b.front - !!a.front)) {
            const text = chosen.length > 1 ? p.sample : p.label, w = ctx.measureText(text).width, h = 12 * ratio, [x, y] = at(p), gap = 8 * ratio;
            if (chosen.length > 1 && !ends.includes(p)) continue;
            const spots = [[x + gap, y - h], [x + gap, y - h / 2], [x - gap - w, y - h / 2], [x - w / 2, y - gap - h], [x - w / 2, y + gap]];
            const spot = spots.find(([a, b]) => a >= left && b >= top && a + w <= left + width + 22 * ratio && b + h <= top + height &&
              taken.every(r => a + w < r[0] || a > r[2] || b + h < r[1] || b > r[3]));
            if (!spot) continue;
            taken.push([spot[0], spot[1], spot[0] + w, spot[1] + h]);
            ctx.fillStyle = p.front ? t.get('ink') : t.get('muted');
            ctx.fillText(text, spot[0], spot[1] + h * .85);
          }
        },
      }];
    };
    const choices = [[-1, 'all samples'], ...samples.map((sample, i) => [i, sample.title])];
    const controls = samples.length > 1 ? [model.select('Sample', 'sample', choices, ['pareto'])] : [];
    new Plot(figure, model, spec, controls, [model.legend('methods', labels.map(label => [label, curveOf(label)]))]);
  }

  // ---------------------------------------------------------------- start

  document.documentElement.classList.add('js');
  (document.querySelector('main') ?? document.body).append(live);
  document.querySelectorAll('section.sample').forEach(section => {
    const index = +section.dataset.sample;
    if (samples[index]) sampleModel(samples[index], index, section);
  });
  document.querySelectorAll('figure.plot[data-plot=pareto]').forEach(pareto);

  // Charts are drawn when they come near the window.
  const near = new IntersectionObserver(entries => entries.filter(e => e.isIntersecting).forEach(e => {
    near.unobserve(e.target);
    plots.find(p => p.area === e.target).build();
  }), { rootMargin: '400px' });
  const size = new ResizeObserver(entries => entries.forEach(e => plots.find(p => p.area === e.target).resize()));
  plots.forEach(p => { near.observe(p.area); size.observe(p.area); });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => plots.forEach(p => p.render()));
})();
