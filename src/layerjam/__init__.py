"""layerjam: soft layer-jamming brakes."""
from layerjam._version import __version__
__all__ = ["__version__"]
