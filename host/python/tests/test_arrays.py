"""What goes in and what comes out: shapes, precisions, memory layouts, refusals."""

import asperity
import numpy as np
import pytest
from oracle import directions

COUNT = 1500  # three blocks, the last not full
LAWS = [asperity.Ggx(0.3, 1.49), asperity.Normals(8.0, ior=1.49)]
NAMES = ["eval", "ars", "pdf"]


@pytest.fixture
def pairs():
    return directions(COUNT, 1), directions(COUNT, 2)


@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("name", NAMES)
def test_shapes_and_precisions(law, name, pairs):
    value = getattr(law, name)
    wi, wo = pairs
    all_of = value(wi, wo)
    assert all_of.shape == (COUNT,) and all_of.dtype == np.float64
    assert np.all(all_of >= 0) and np.any(all_of > 0)
    single = value(wi.astype(np.float32), wo.astype(np.float32))
    assert single.shape == (COUNT,) and single.dtype == np.float32
    assert value(wi.astype(np.float32), wo).dtype == np.float64
    one = value(wi[0], wo[0])
    assert isinstance(one, np.float64) and one == all_of[0]
    assert isinstance(value(np.float32([0, 0, 1]), np.float32([0, 0, 1])), np.float32)
    assert value(wi[:0], wo[:0]).shape == (0,)
    assert value(wi[:1], wo[0]).shape == (1,)


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_one_vector_goes_with_many(law, pairs):
    wi, wo = pairs
    repeated = np.tile(wi[3], (COUNT, 1))
    for name in NAMES:
        value = getattr(law, name)
        np.testing.assert_array_equal(value(wi[3], wo), value(repeated, wo))
        np.testing.assert_array_equal(value(wi[3:4], wo), value(repeated, wo))
        np.testing.assert_array_equal(value(wo, wi[3]), value(wo, repeated))


def test_layout_in_memory_does_not_matter(pairs):
    law = LAWS[0]
    wi, wo = pairs
    right = law.eval(wi, wo)
    fortran = np.asfortranarray(wi)
    spaced = np.zeros((2 * COUNT, 5))[::2, 1:4]
    spaced[:] = wi
    backwards = wi[::-1].copy()[::-1]
    other_end = wi.astype(">f8")
    packed = np.zeros(COUNT, dtype=[("flag", "i1"), ("w", "f8", 3)])["w"]
    packed[:] = wi
    steps = np.zeros(COUNT, dtype=[("w", "f8", 3), ("flag", "i4")])["w"]
    steps[:] = wi
    for layout in (fortran, spaced, backwards, other_end, packed, steps, wi.tolist()):
        np.testing.assert_array_equal(law.eval(layout, wo), right)
    read_only = wi.copy()
    read_only.flags.writeable = False
    np.testing.assert_array_equal(law.eval(read_only, wo), right)
    np.testing.assert_array_equal(law.eval(wi, wi), law.eval(wi.copy(), wi))


def test_whole_numbers_and_lists_are_directions():
    law = LAWS[0]
    assert law.eval([0, 0, 1], [0, 0, 1]) == law.eval([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]) > 0


@pytest.mark.parametrize(
    ("wi", "words"),
    [
        (np.zeros((4, 2)), "shape (4, 2)"),
        (np.zeros((3, 4)), "shape (3, 4)"),
        (np.zeros((2, 2, 3)), "shape (2, 2, 3)"),
        (np.float64(1.0), "shape ()"),
        (np.tile([0.0, 0.0, 1.0], (7, 1)), "7 rows"),
        (np.array([[0, 0, 1j]]), "complex128"),
        (["a", "b", "c"], "real numbers"),
        (np.array([True, False, True]), "real numbers"),
        (None, "real numbers"),
        ([0.0, 0.0, 2.0], "wi[0] has length 2"),
        ([0.0, np.inf, 0.0], "wi[0] has length inf"),
    ],
)
def test_what_is_no_direction_is_refused(wi, words):
    wo = np.tile([0.0, 0.6, 0.8], (5, 1))
    for name in NAMES:
        with pytest.raises(ValueError) as error:
            getattr(LAWS[0], name)(wi, wo)
        assert words in str(error.value)


def test_the_row_at_fault_is_named(pairs):
    wi, wo = pairs
    wo = wo.copy()
    wo[1234] *= 1.01
    with pytest.raises(ValueError, match=r"wo\[1234\] has length 1\.01"):
        LAWS[0].eval(wi, wo)
    with pytest.raises(ValueError, match="real numbers|inhomogeneous"):
        LAWS[0].eval([[0, 0, 1], [0, 1]], wo)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_nan_goes_through_and_stays_in_its_row(law, dtype, pairs):
    wi, wo = (w.astype(dtype) for w in pairs)
    right = law.eval(wi, wo)
    for name in NAMES:
        wi_nan, wo_nan = wi.copy(), wo.copy()
        wi_nan[7, 0] = wo_nan[600] = np.nan
        found = getattr(law, name)(wi_nan, wo_nan)
        assert found.dtype == dtype
        assert np.flatnonzero(np.isnan(found)).tolist() == [7, 600]
    assert not np.isnan(right).any()


def test_parameters_outside_their_domain_are_refused_in_the_words_of_the_library():
    for make, words in [
        (lambda: asperity.Ggx(0.0, 1.49), "parameter `alpha` = 0 is outside its domain"),
        (lambda: asperity.Ggx(np.nan, 1.49), "alpha"),
        (lambda: asperity.Ggx(0.3, 0.0), "refractive index 0"),
        (lambda: asperity.Normals(-1.0, ior=1.49), "`delta` = -1 is outside"),
        (lambda: asperity.Normals(1.0, n=1e3, ior=1.49), "`n`"),
        (lambda: asperity.Normals(1.0, theta0_deg=91, ior=1.49), "`theta0`"),
        (lambda: asperity.Normals(1.0, profile="phong", ior=1.49), "gauss or cauchy"),
    ]:
        with pytest.raises(ValueError) as error:
            make()
        assert words in str(error.value)
    with pytest.raises(TypeError):
        asperity.Normals(1.0)
