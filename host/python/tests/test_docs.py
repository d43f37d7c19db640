"""What `help` shows: every public name is documented, with shapes, units and errors."""

import inspect
import re
from pathlib import Path

import asperity
import pytest

CLASSES = [thing for name in asperity.__all__ if inspect.isclass(thing := getattr(asperity, name))]
MEMBERS = [
    (f"{cls.__name__}.{name}", member.__func__ if isinstance(member, staticmethod) else member)
    for cls in CLASSES
    for name, member in vars(cls).items()
    if not name.startswith("_")
]
FUNCTIONS = [(name, thing) for name in asperity.__all__ if inspect.isroutine(thing := getattr(asperity, name))]
SECTIONS = ["Parameters", "Returns", "Raises", "Notes"]


def is_attribute(member):
    return inspect.isgetsetdescriptor(member) or inspect.ismemberdescriptor(member)


def sections(doc):
    """Heading and text of each section of a numpydoc string."""
    parts = re.split(r"^(\w+)\n-{3,}\n", inspect.cleandoc(doc), flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2]))


def test_there_is_something_to_read():
    assert len(CLASSES) >= 5 and len(MEMBERS) >= 40 and len(FUNCTIONS) >= 2


@pytest.mark.parametrize("thing", CLASSES, ids=lambda c: c.__name__)
def test_a_class_says_what_it_is(thing):
    assert thing.__doc__ and thing.__doc__[0].isupper() and "no constructor" not in thing.__doc__


@pytest.mark.parametrize("name, member", MEMBERS + FUNCTIONS, ids=lambda x: x if isinstance(x, str) else "")
def test_a_member_says_what_it_takes_gives_and_raises(name, member):
    doc = inspect.getdoc(member)
    assert doc, f"{name} has no docstring"
    if is_attribute(member):
        assert re.match(r"[\w., ]+(\([N, 3]+\))?: [A-Z]", doc), f"{name}: no type in {doc!r}"
        return
    assert doc.splitlines()[0].endswith("."), f"{name}: {doc.splitlines()[0]}"
    found = sections(doc)
    assert set(found) <= set(SECTIONS) and list(found) == [s for s in SECTIONS if s in found], name
    takes = [p for p in inspect.signature(member).parameters if p != "self"]
    for parameter in takes:
        lines = found.get("Parameters", "")
        assert re.search(rf"^([\w, ]+, )?{parameter}(, [\w, ]+)? : ", lines, re.MULTILINE), f"{name}: {parameter}"


@pytest.mark.parametrize("law", [asperity.Ggx, asperity.Normals, asperity.Model, asperity.Table])
def test_values_say_their_shapes_units_and_errors(law):
    for name in ("eval", "ars", "pdf", "sample"):
        doc = getattr(law, name).__doc__
        assert "(N, 3)" in doc and "ValueError" in doc, name
        assert name == "sample" or "1/sr" in doc, name


def test_the_stub_knows_the_same_names():
    stub = (Path(asperity.__file__).parent / "_native.pyi").read_text()
    for name, _ in MEMBERS + FUNCTIONS:
        assert re.search(rf"\bdef {name.split('.')[-1]}\(", stub), name
