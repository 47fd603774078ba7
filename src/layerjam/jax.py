"""Brakes as pytrees of JAX: import this module before JAX sees a brake.

A law that is called with arrays of JAX makes every record a pytree by itself. If JAX meets a brake
first, as in ``jax.grad(energy)(brake)``, it needs ``import layerjam.jax`` before.
"""

from layerjam.brake.mechanics.tracing import double_precision

__all__ = ["double_precision"]
