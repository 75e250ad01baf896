"""Bridge from the parameters of rock engineers (JRC, JCS, phi_r) to the constants of the law."""

from .joint import Joint as Joint
