"""The native part; import from ``asperity``.

Arrays of directions have the shape (N, 3) or (3,); one vector goes with any number of the other. Results have the shape
(N,), or are numbers if both arguments are one vector. float32 is computed with if both arguments are float32 arrays.
"""

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Values: TypeAlias = Any
"""Array (N,) of float32 or float64, or a number of numpy."""

_Samples: TypeAlias = tuple[NDArray[Any], Any]
"""Directions wo (N, 3) and weights (N,); a lost ray has the weight 0 and NaN for its direction."""

_Lines: TypeAlias = float | Sequence[float] | Sequence[tuple[float, float]]
"""Vacuum wavelengths, nm: one, several of the same weight, or pairs with weights."""

__all__ = [
    "Ggx",
    "HeightMap",
    "Model",
    "Normals",
    "Scan",
    "Table",
    "__version__",
    "check",
    "compare",
    "fit",
    "read_map",
    "read_scan",
    "scan",
]
__version__: str

@final
class Ggx:
    """GGX facets on a clear dielectric.

    ``alpha``: width of the slopes, 1e-6 to 100; ``ior``: index of the dielectric over that of air, 0.1 to 10.
    """

    def __new__(cls, alpha: float, ior: float) -> Ggx: ...
    @property
    def alpha(self) -> float: ...
    @property
    def ior(self) -> float: ...
    def eval(self, wi: ArrayLike, wo: ArrayLike) -> _Values:
        """The BSDF f(wi, wo), 1/sr, without cosine."""
    def ars(self, wi: ArrayLike, wo: ArrayLike) -> _Values:
        """f |cos theta_o|, 1/sr."""
    def pdf(self, wi: ArrayLike, wo: ArrayLike) -> _Values:
        """Density of ``sample`` at wo, 1/sr."""
    def sample(self, wi: ArrayLike, u: ArrayLike) -> _Samples:
        """Draws rays from uniforms u (N, 3) in [0, 1)."""

@final
class Normals:
    """A density of facet normals on a clear dielectric, one facet at each hit.

    ``delta_deg``: width, degrees; ``n``: exponent; ``theta0_deg``: centre, degrees.
    """

    def __new__(
        cls,
        delta_deg: float,
        n: float = 2.0,
        theta0_deg: float = 0.0,
        profile: Literal["gauss", "cauchy"] = "gauss",
        *,
        ior: float,
    ) -> Normals: ...
    @property
    def ior(self) -> float: ...
    def eval(self, wi: ArrayLike, wo: ArrayLike) -> _Values:
        """The BSDF f(wi, wo), 1/sr, without cosine."""
    def ars(self, wi: ArrayLike, wo: ArrayLike) -> _Values:
        """f |cos theta_o|, 1/sr."""
    def pdf(self, wi: ArrayLike, wo: ArrayLike) -> _Values:
        """Density of ``sample`` at wo, 1/sr."""
    def sample(self, wi: ArrayLike, u: ArrayLike) -> _Samples:
        """Draws rays from uniforms u (N, 3) in [0, 1); more, where needed, come from a generator seeded by the row."""

@final
class Model:
    """A model file of any method.

    Models of height maps have no closed form: ``eval``, ``ars`` and ``pdf`` trace ``rays`` rays an incidence into a table
    first, as ``asperity eval`` does, and call for seconds. ``sample`` does not.
    """

    @staticmethod
    def load(path: str | PathLike[str]) -> Model: ...
    @staticmethod
    def from_json(text: str) -> Model: ...
    def to_json(self) -> str: ...
    def save(self, path: str | PathLike[str]) -> None: ...
    @property
    def method(self) -> str: ...
    @property
    def profile(self) -> str | None: ...
    @property
    def ior(self) -> float | None:
        """Index over that of air; None for an opaque body."""
    @property
    def parameters(self) -> dict[str, float]: ...
    @property
    def std_errors(self) -> dict[str, float | None]:
        """None where a value was given, or is not determined by the data."""
    @property
    def units(self) -> dict[str, str]: ...
    @property
    def rmsd_percent(self) -> float | None:
        """Error of eq. (18), % of the largest reading; None without a fit."""
    @property
    def noise_floor_percent(self) -> float | None: ...
    @property
    def termination(self) -> str | None: ...
    @property
    def warnings(self) -> list[str]:
        """Why the model should not be trusted, in plain words; empty if there is no reason."""
    @property
    def verdict(self) -> Literal["within-noise", "misfit", "not-identifiable", "not-described", "unphysical"] | None:
        """What a fit is worth; None if it is no fit."""
    @property
    def causes(self) -> list[str]:
        """Why the verdict is not the best one."""
    def eval(self, wi: ArrayLike, wo: ArrayLike, *, rays: int = 1_000_000, seed: int = 1) -> _Values:
        """The BSDF f(wi, wo), 1/sr, without cosine."""
    def ars(self, wi: ArrayLike, wo: ArrayLike, *, rays: int = 1_000_000, seed: int = 1) -> _Values:
        """f |cos theta_o|, 1/sr."""
    def pdf(self, wi: ArrayLike, wo: ArrayLike, *, rays: int = 1_000_000, seed: int = 1) -> _Values:
        """Density at wo, 1/sr."""
    def sample(self, wi: ArrayLike, u: ArrayLike) -> _Samples:
        """Draws rays from uniforms u (N, 3) in [0, 1); more, where needed, come from a generator seeded by the row."""

@final
class Table:
    """A table made by ``asperity tabulate`` (.bsdft)."""

    @staticmethod
    def load(path: str | PathLike[str]) -> Table: ...
    @property
    def method(self) -> str: ...
    @property
    def ior(self) -> float | None:
        """Index over that of air; None for an opaque body."""
    @property
    def opaque(self) -> bool: ...
    @property
    def has_checksum(self) -> bool:
        """False for a file of format 1, of which damage goes unseen."""
    @property
    def storage(self) -> Literal["u8", "u16", "f32"]: ...
    @property
    def nbytes(self) -> int: ...
    @property
    def distance_percent(self) -> float | None:
        """Distance from the model it was made of, eq. (18), %."""
    def eval(self, wi: ArrayLike, wo: ArrayLike) -> _Values:
        """The BSDF f(wi, wo), 1/sr, without cosine."""
    def ars(self, wi: ArrayLike, wo: ArrayLike) -> _Values:
        """f |cos theta_o|, 1/sr."""
    def pdf(self, wi: ArrayLike, wo: ArrayLike) -> _Values:
        """Density of the diffuse samples at wo, 1/sr."""
    def sample(self, wi: ArrayLike, u: ArrayLike) -> _Samples:
        """Draws rays from uniforms u (N, 3) in [0, 1), coherent ones included."""

@final
class Scan:
    """Readings over angles; sorted by incidence, then by observation angle.

    ``meta``: the header of a scan file as keys and values (geometry, ior, rough_side, aperture_deg, quantity, ...).
    """

    def __new__(
        cls,
        sigma_deg: Sequence[float] | NDArray[Any],
        theta_deg: Sequence[float] | NDArray[Any],
        reading: Sequence[float] | NDArray[Any],
        meta: Mapping[str, Any] | None = None,
    ) -> Scan: ...
    @property
    def sigma_deg(self) -> NDArray[np.float64]:
        """Angles of incidence, degrees, (N,)."""
    @property
    def theta_deg(self) -> NDArray[np.float64]:
        """Angles of observation, degrees, (N,)."""
    @property
    def reading(self) -> NDArray[np.float64]:
        """Relative flux, or BSDF in 1/sr, (N,)."""
    @property
    def quantity(self) -> Literal["flux", "bsdf"]: ...
    @property
    def meta(self) -> dict[str, Any]: ...
    def __len__(self) -> int: ...

def read_scan(path: str | PathLike[str]) -> Scan:
    """Reads a standard scan file."""

@final
class HeightMap:
    """A measured height map, made ready for light; read one with ``read_map``."""

    @property
    def heights_um(self) -> NDArray[np.float64]:
        """Heights, um, (ny, nx): rows are y, columns x."""
    @property
    def pitch_um(self) -> tuple[float, float]:
        """Distances of neighbouring points along x and y, um."""
    @property
    def edges(self) -> Literal["periodic", "mirrored"]: ...
    @property
    def format(self) -> str: ...
    @property
    def warnings(self) -> list[str]: ...
    def roughness(self) -> dict[str, float | None]:
        """Roughness figures, as ``asperity stats --json`` names them."""

def read_map(
    path: str | PathLike[str],
    *,
    pixel_um: float | None = None,
    z_um: float | None = None,
    xy_unit: str | None = None,
    z_unit: str | None = None,
    crop: str | None = None,
    fill: Literal["plane", "nearest", "harmonic"] | None = None,
    form: Literal["none", "mean", "plane", "quadratic"] | None = None,
    edges: Literal["periodic", "mirrored"] | None = None,
    channel: int | None = None,
    ignore_checksum: bool = False,
    allow_steep: bool = False,
) -> HeightMap:
    """Reads a height map and makes it ready for light."""

def fit(
    scan: Scan,
    method: str = "ggx",
    *,
    ior: float | None = None,
    opaque: bool = False,
    profile: Literal["gauss", "cauchy"] | None = None,
    free: Sequence[str] | None = None,
    of: Sequence[str] | None = None,
    bounces: Literal["one", "all", "walk"] | None = None,
    body: Literal["sheet", "plate"] | None = None,
    cutoff: bool = True,
    geometry: Literal["transmission", "reflection"] | None = None,
    rough_side: Literal["source", "detector"] | None = None,
    aperture_deg: float | None = None,
    map: HeightMap | None = None,
    wavelength_nm: _Lines | None = None,
    speckle: Literal["averaged", "kept", "patch"] | None = None,
    shadowing: Literal["auto", "on", "off"] | None = None,
    objective: Literal["rmsd", "relative", "log"] = "rmsd",
    max_evaluations: int = 4000,
    max_misfit_percent: float = 15.0,
    rays: int | None = None,
    fit_rays: int | None = None,
    seed: int = 1,
) -> Model:
    """Fits a model; an argument goes before the header of the scan.

    ``free``: optional parameters to fit as well: ior, gain, theta0 (normals), n, h_max, z0 (heights). Without ``profile`` both are
    tried and the better one is kept. Other threads run meanwhile; Ctrl-C ends the fit.
    """

def compare(
    scans: Sequence[Scan],
    *,
    maps: Sequence[HeightMap] | None = None,
    names: Sequence[str] | None = None,
    methods: Sequence[str] | None = None,
    ior: float | None = None,
    opaque: bool = False,
    geometry: Literal["transmission", "reflection"] | None = None,
    rough_side: Literal["source", "detector"] | None = None,
    aperture_deg: float | None = None,
    wavelength_nm: _Lines | None = None,
    speckle: Literal["averaged", "kept", "patch"] | None = None,
    shadowing: Literal["auto", "on", "off"] | None = None,
    objective: Literal["rmsd", "relative", "log"] = "rmsd",
    max_evaluations: int = 4000,
    max_misfit_percent: float = 15.0,
    rays: int | None = None,
    fit_rays: int | None = None,
    seed: int = 1,
) -> dict[str, Any]:
    """Fits every method to every scan; the object that ``asperity compare --json --no-timing`` prints."""

def scan(
    of: Model | Table | HeightMap,
    *,
    sigma_deg: Sequence[float] = (0.0, 15.0, 30.0, 45.0, 60.0),
    theta_deg: tuple[float, float] = (-90.0, 90.0),
    step_deg: float = 0.1,
    aperture_deg: float = 0.6,
    geometry: Literal["transmission", "reflection"] | None = None,
    rough_side: Literal["source", "detector"] = "source",
    quantity: Literal["flux", "bsdf"] = "flux",
    rays: int | None = None,
    seed: int = 1,
    ior: float | None = None,
    engine: Literal["ray", "wave", "hybrid"] | None = None,
    wavelength_nm: _Lines | None = None,
    speckle: Literal["averaged", "kept", "patch"] | None = None,
    shadowing: Literal["auto", "on", "off"] | None = None,
) -> Scan:
    """Simulates a goniophotometer scan; a map needs ``ior``."""

def check(
    of: Model | Table | HeightMap,
    *,
    incidences_deg: Sequence[float] = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0),
    side: Literal["air", "dielectric"] | None = None,
    rays: int = 1_000_000,
    seed: int = 1,
    ior: float | None = None,
    engine: Literal["ray", "wave", "hybrid"] | None = None,
    wavelength_nm: _Lines | None = None,
    speckle: Literal["averaged", "kept", "patch"] | None = None,
    shadowing: Literal["auto", "on", "off"] | None = None,
) -> dict[str, Any]:
    """Says where the flux goes; the object that ``asperity check --json`` prints."""
