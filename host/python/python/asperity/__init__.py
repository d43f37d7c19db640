"""Evaluate, sample and fit the BSDF of rough optical surfaces.

Directions are unit vectors that point away from the surface; +z is the mean normal and points into the air.
``eval`` is the BSDF f in 1/sr without cosine, ``ars`` is f |cos theta_o|, ``pdf`` the density of ``sample``.
Flux is transported, not radiance: transmission carries no eta^2.
"""

from ._native import Ggx, Model, Normals, Scan, Table, __version__, fit, read_scan

__all__ = ["Ggx", "Model", "Normals", "Scan", "Table", "__version__", "fit", "read_scan"]
