"""The parameter search spaces of Tables 4 and 9."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from roomseg.classifier import ClassifierParameters

__all__ = ["BASIC", "COARSE", "EXTRAFINE", "FINE", "FULL", "NO_CAMERA", "NO_CEILING", "Grid"]

Values = tuple[float, ...]


@dataclass(frozen=True)
class Grid:
    """All combinations of some values of log₂ C, log₂ γ, w and ρ."""

    log2_c: Values
    log2_gamma: Values
    class_weight: Values
    rho: Values

    def combinations(self) -> tuple[ClassifierParameters, ...]:
        """The p combinations, ρ varying fastest."""
        return tuple(
            ClassifierParameters(2.0**c, 2.0**gamma, w, rho)
            for c, gamma, w, rho in product(
                self.log2_c, self.log2_gamma, self.class_weight, self.rho
            )
        )


def _steps(first: float, step: float, last: float) -> Values:
    """Values as Table 4 writes them, first : step : last."""
    count = round((last - first) / step)
    return tuple((first + step * np.arange(count + 1)).tolist())


RHO = _steps(20, 20, 120)

FULL = Grid(_steps(-9, 2, 9), _steps(-15, 2, -1), (20.0, 40.0, 60.0), RHO)
FINE = Grid(_steps(-9, 1, 5), _steps(-9, 1, 0), (40.0,), _steps(50, 10, 80))
EXTRAFINE = Grid(_steps(-6.5, 0.5, 0.5), _steps(-5.5, 0.5, -0.5), (40.0,), (50.0, 60.0, 70.0))
BASIC = Grid(_steps(-9, 2, 9), _steps(-15, 2, -1), (40.0,), RHO)
NO_CAMERA = Grid(_steps(-9, 2, 11), _steps(-15, 2, 1), (40.0,), (2.5, 5.0, 10.0, 20.0))
NO_CEILING = Grid(_steps(-9, 2, 15), _steps(-19, 2, -1), (40.0,), RHO)
COARSE = Grid((-3.0, 1.0), (-7.0, -3.0), (40.0,), (20.0, 60.0))
"""Not the paper's: eight combinations, to try everything out."""
