"""The page about the paper, part by part: titles, pictures and what is said under them."""

from __future__ import annotations

import functools
from collections.abc import Mapping

from layerjam.report import (
    density_figures,
    fluid_figures,
    impact_figures,
    line_pictures,
    stack_figures,
)
from layerjam.report.page import Picture
from layerjam.studies.choi2018 import figures as paper_figures
from layerjam.studies.choi2018 import machines as paper_machines
from layerjam.studies.choi2018 import sensor_figures, speed_figures
from layerjam.studies.choi2018.lab import FilmRun
from layerjam.studies.choi2018.page import Part

Numbers = dict[str, dict[str, float]]


def paper_parts(lab: Mapping[str, FilmRun]) -> list[Part]:
    """The parts in their order, without their claims."""
    exact = {
        name: {
            "scale_factor": run.calibration.scale_factor,
            "eq9": run.calibration.stiffness_eq9 or 0.0,
        }
        for name, run in lab.items()
    }
    return [
        _device(), _materials(), _friction(), _calibration(exact), _damping(), _control(),
        _density(), paper_machines.part(),
    ]  # fmt: skip


def _device() -> Part:
    return Part(
        id="device",
        title="The brake and its equations (II)",
        pictures=[
            Picture(
                name="eq5", figure=paper_figures.eq5,
                caption="Left: equation 5 with x inside the root, and as printed. Right: the "
                "force of the whole Kapton brake at low vacuum; only below 1.06 kPa does it "
                "rise all the way.",
            ),
            Picture(
                name="closing", figure=paper_figures.buckling_and_closing,
                caption="Not in the paper: an unloaded brake is closed again by its own sleeve "
                "below this vacuum.",
            ),
        ],
    )  # fmt: skip


def _materials() -> Part:
    return Part(
        id="materials",
        title="Films, air and water (III-A, III-B)",
        pictures=[
            Picture(
                name="fig4", figure=paper_figures.fig4,
                caption="Fig. 4 from the model: 94.5, 65.5, 31.0 and 0 kPa. Quasi-static, "
                "without stick–slip. Polyester and fibreglass rest on handbook friction.",
            ),
            Picture(
                name="fig4-judder", figure=speed_figures.fig4_judder,
                caption="Why Fig. 4 shows the opposite of table I. Left: the saw of a slow "
                "pull, all interfaces at once and let go one after another. Right: which film "
                "judders at 1 mm/s over the Stribeck speed and the damping, neither of which "
                "is measured; the moving mass, half of a brake, is assumed.",
            ),
            Picture(
                name="judder-map", figure=speed_figures.amplitude,
                caption="Not in the paper: how fast one must pull. Half of the force's swing "
                "over pulling speed and vacuum (blank: it slides steadily; the line is the "
                "closed form, which holds while the spring stays taut), and the critical speed "
                "over the stiffness of brake and mount.",
            ),
            Picture(
                name="fig5", figure=fluid_figures.fig5,
                caption="Fig. 5 from the model of the line. Left: the paper prints no volume "
                "and no compliance, so that both times are met by construction; the shapes are "
                "the model's. Right: rise times of other lines.",
            ),
            Picture(
                name="fig6", figure=speed_figures.fig6,
                caption="Fig. 6 redrawn: Kapton dry (solid) and wet. The wet parameters are "
                "illustrative, chosen after the paper's words and fitted to nothing; at "
                "25 mm/s two sets show the two readings of its sentence.",
            ),
        ],
    )  # fmt: skip


def _friction() -> Part:
    return Part(
        id="friction",
        title="Friction and validation before calibration (III-C)",
        text=["Procedures run on synthetic files, three repeats a film, whose truth is the "
              "paper's table I with its standard deviations."],
        pictures=[
            Picture(
                name="fig7-9", figure=paper_figures.fig7_9,
                caption="Fig. 7 and 9 from the model at 80.6, 46.1 and 18.6 kPa: dashed before "
                "calibration, solid after; the band is what the scale factor changes.",
            ),
        ],
    )  # fmt: skip


def _calibration(exact: Numbers) -> Part:
    return Part(
        id="calibration",
        title="Calibration (III-D)",
        pictures=[
            Picture(
                name="fig8", figure=functools.partial(paper_figures.fig8, exact),
                caption="Fig. 8 from the model with k of the paper's text. The three dashed "
                "lines are the stiffness in the text, the one in the caption, and what eq. 9 "
                "gives on this curve.",
            ),
            Picture(
                name="stack-onset", figure=stack_figures.onset,
                caption="Not in the paper, which names it as the reason to leave static "
                "friction out: the sheets do not slide at once. Each sheet a spring, each "
                "interface a friction of its own.",
            ),
            Picture(
                name="stack-spread", figure=stack_figures.spread,
                caption="Monte Carlo over the interfaces of the same brake in its rig: the "
                "friction of each is drawn anew, everything else stays. The scatter of 10 % "
                "is assumed.",
            ),
        ],
    )  # fmt: skip


def _damping() -> Part:
    return Part(
        id="damping",
        title="Collisions (III-E)",
        pictures=[
            Picture(
                name="fig11",
                figure=impact_figures.fig11,
                caption="Fig. 11 from the model. Green: the vacuum tuned, gravity and elastic "
                "parts included, so that the brake slips 40 mm; dashed: the least peak of any "
                "stop within that way, whatever does the stopping. Red: what the paper reads "
                "off its figure.",
            ),
            Picture(
                name="accelerometer", figure=sensor_figures.readings,
                caption="The stop at 2.5 m/s as accelerometers show it: ideal, with the "
                "ADXL193's low-pass (400 Hz; its order is assumed), and through the filters of "
                "SAE J211-1. None hides more than a thirtieth of the peak.",
            ),
            Picture(
                name="filter-and-rope", figure=sensor_figures.what_it_takes,
                caption="What it would take to show the paper's peaks. Left: a low-pass of a "
                "few hertz, behind which the bare drop would not show its 50 g. Right: no rope "
                "does; on one soft enough the brake never slips.",
            ),
        ],
    )  # fmt: skip


def _control() -> Part:
    return Part(
        id="control",
        title="Not in the paper: the hand on the pump",
        text=["The paper sets a vacuum and waits. Here the same line is regulated, made to "
              "follow a force, and asked whether it is in time. Sensor (50 Pa of noise), leak "
              "and valve are examples of ours, not measurements."],
        pictures=[
            Picture(
                name="regulators", figure=line_pictures.regulators,
                caption="Left: what each regulator makes of 80 kPa and how often it switches "
                "the pump for it. Right: a pump that dies. The regulator says so and goes to "
                "the safe state that its configuration had to declare.",
            ),
            Picture(
                name="forces", figure=line_pictures.forces,
                caption="Wanted force and measured slip give the vacuum by the inverse law. "
                "The true brake rubs 3 % more than the controller knows; the slip is noisy by "
                "0.1 mm and grows by 0.5 mm a second. The saw on the plateau is the vent, "
                "which opens when the vacuum is 1 % of the pump's too high.",
            ),
            Picture(
                name="plan", figure=line_pictures.warned,
                caption="A collision announced 3 s before: the vacuum that comes in time, and "
                "the two modes of the paper over an uncertain energy. Tuned, the mass feels "
                "less and the travel runs out more often.",
            ),
        ],
    )  # fmt: skip


def _density() -> Part:
    return Part(
        id="density",
        title="Force density (III-F)",
        pictures=[
            Picture(
                name="sheets", figure=paper_figures.sheets_and_mass,
                caption="Peak force over mass as sheets are added to the Kapton brake.",
            ),
            Picture(
                name="fig12", figure=density_figures.fig12,
                caption="Fig. 12 from the mass model, beside devices whose mass and force "
                "stand in a source that could be read. Classes without one are not drawn.",
            ),
        ],
    )  # fmt: skip
