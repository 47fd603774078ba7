"""`lift`: how often a brake holds its own weight."""

from layerjam.brake.commands.arguments import BrakeInput, Vacuum
from layerjam.brake.device.brake import mass
from layerjam.brake.mechanics.friction import holding_force
from layerjam.core.command.declare import command
from layerjam.core.command.results import Result, number, result


@result
class Lift(Result):
    """Holding force of a brake, and its ratio to the weight of the brake."""

    holding_force: float = number("N", "static friction of the sheets")
    weights: float = number("1", "ratio of that force to the weight of the brake")


@command("predict")
def lift(brake: BrakeInput, *, vacuum: Vacuum) -> Lift:
    """Compute how many times its own weight a brake holds at a vacuum."""
    device = brake.brake
    force = float(holding_force(vacuum, device))
    return Lift(holding_force=force, weights=force / (mass(device) * device.site.gravity))
