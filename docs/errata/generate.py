"""Write the page of the errata, index.md, and its pictures, from what the package recomputes and simulates.

Usage: make errata
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import governor_mechanism as gm
from governor_mechanism.closed_form.flywheel_engine import net_work
from governor_mechanism.closed_form.flywheel_equilibrium import energy_fluctuation
from governor_mechanism.papers.errata_drawings import draw_erratum
from governor_mechanism.papers.erratum import CAUSE_MEANINGS, CAUSE_NOUNS, PAPER_REFERENCES, Erratum, Paper
from governor_mechanism.studies.design.flywheel import PAPER_ENGINE, closed_cycle, compare_with_paper
from governor_mechanism.studies.design.hartung import PAPER_GOVERNOR, PAPER_INPUTS
from governor_mechanism.studies.design.hartung import compare_with_paper as compare_with_dubois
from governor_mechanism.studies.design.skeleton import Cause
from governor_mechanism.units.constants import KILOGRAM_FORCE_1853

FOLDER = Path(__file__).parent

TITLES = {
    Paper.REDTENBACHER: "Redtenbacher 1853: the flywheel of an air engine",
    Paper.ZEHNDER: "Zehnder 1877: pendulum governors",
    Paper.MARKS: "Müller-Melchiors 1881: Marks' construction for the slide valve",
    Paper.DUBOIS: "Dubois 1912: Hartung's governor",
}
"""Headings of the papers."""

PICTURES = {
    Paper.REDTENBACHER: "Speed of the shaft over a turn: the printed flywheel leaves the allowed band, the right one hardly exceeds it",
    Paper.ZEHNDER: "Change of the speed of rest beside the point of osculation, for three arms: true, and as the paper reasons",
    Paper.MARKS: "Changes of compression, pre-release, pre-admission and fill at both ends of the cylinder, and what the paper states",
    Paper.DUBOIS: "Bell crank at 132 and 137.33 degrees, drawn to angle, and the static sleeve force over the stroke with each",
}
"""What each picture shows."""

PICTURE_NOTES = {
    Paper.REDTENBACHER: "Speeds by the closed form, under the load that closes the cycle. Areas, stroke and µ = 20 are chosen; the paper "
    "leaves them open.",
    Paper.ZEHNDER: "Lowest speed 120 rpm and m = 4 are chosen; the paper prints no example.",
    Paper.MARKS: "Eccentric rod four times as long as the eccentric, as in the paper; the other dimensions are those of the scene "
    "`slide_valve_marks`, and the connecting rod is infinitely long. What the paper states of the end whose fill shrinks is written at the "
    "crank end, which is at the shaft; the paper gives it to the end away from the shaft.",
    Paper.DUBOIS: "132° is the angle of the paper's governor, and of the scene `hartung_dubois`: the even number next to the 133° that is "
    "printed for the formula. With each angle the springs follow the straight line through both speeds, and the hangers are symmetric "
    "about the axis.",
}
"""What a picture assumes."""

GREEK = {"alpha": "α", "gamma": "γ", "delta": "δ", "epsilon": "ε", "phi": "φ", "rho": "ρ", "pi": "π", "mu": "µ", "xi": "ξ"}
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")

INTRODUCTION = """\
# Errata of the four papers

The machines of this package come from four papers. Every number that they print was recomputed by their own formulas, and what they state
was compared with the simulated machines. This page lists what does not agree: what is printed, what is right, why, and what follows.

There are {counts}:

| cause | what it is | number |
|---|---|---|
{causes}

The papers were read in digital copies (Dinglers Polytechnisches Journal online; Badische Landesbibliothek,
Karlsruhe); the printed pages were not at hand. What is evidently of the copy is left out: l for 1, words read
wrongly, missing images. Where nothing but a typeface, an index, an exponent, a bracket or a dropped factor
differs, it is undecided whether the paper is wrong at all. A wrong digit or sign counts as a misprint, of the
paper or of the copy. The other causes do not depend on the copy: each concerns a statement in words, or a
number that others of the paper agree with or that its own rounded steps give.

The page is generated from

```sh
governor-mechanism errata
```

which recomputes every right value by the closed forms when it is called, and draws the pictures. `--paper` takes one paper; with
`--simulate` the machines that show the main errors are simulated too:

```sh
governor-mechanism errata --paper zehnder --simulate --no-figure
```

In Python, the errata are a result like any other:

```python
import governor_mechanism as gm

errata = gm.errata("dubois")
for erratum in errata:
    if erratum.cause == "error":
        print(erratum.place, erratum.printed, erratum.right, sep="; ")
```

Units are those of the papers: a kilogram-force (kgf) is the weight of one kilogram, {gravity} N as the papers take it.
"""


def write_page() -> str:
    """Return the text of the page."""
    errata = gm.errata(simulate=True)
    rows = "\n".join(f"| {cause} | {CAUSE_MEANINGS[cause]} | {number} |" for cause, number in errata.count_causes().items())
    parts = [INTRODUCTION.format(counts=errata.describe_counts(), causes=rows, gravity=KILOGRAM_FORCE_1853)]
    parts.append(write_overview(errata))
    parts += [write_paper(paper, errata) for paper in errata.papers]
    return "\n".join([*parts, write_correct_statements()])


def write_overview(errata: gm.Errata) -> str:
    """Return the table of the errors of all papers and of their consequences."""
    found = [one for one in errata if one.cause in {Cause.ERROR, Cause.CONSEQUENCE}]
    cells = [(author_of(one.paper), one.cause, *map(typeset, (one.subject, one.printed, one.right))) for one in found]
    rows = ["| " + " | ".join(row) + " |" for row in cells]
    head = ["## The errors at a glance", "", "| paper | cause | subject | printed | right |", "|---|---|---|---|---|"]
    return "\n".join([*head, *rows, ""])


def author_of(paper: Paper) -> str:
    """Return the name of the author of a paper."""
    return TITLES[paper].split()[0]


def write_paper(paper: Paper, errata: gm.Errata) -> str:
    """Return the section of a paper."""
    lines = [
        f"## {TITLES[paper]}",
        "",
        f"{PAPER_REFERENCES[paper]}.",
        "",
        f"![{PICTURES[paper]}]({paper}.png)",
        "",
        PICTURE_NOTES[paper],
        "",
    ]
    for cause in Cause:
        found = errata.select(paper, cause)
        if found:
            # The heading names the paper, so that the anchors differ.
            lines += [f"### {author_of(paper)}: {CAUSE_NOUNS[cause]}{'s' * (len(found) > 1)}", ""]
        far_reaching = [one for one in found if one.consequence]
        lines += [line for one in far_reaching for line in write_paragraph(one)]
        if others := [one for one in found if not one.consequence]:
            lines += [*write_table(others), ""]
    return "\n".join(lines)


def write_paragraph(erratum: Erratum) -> Iterator[str]:
    """Yield the lines of an erratum with consequences: where, printed and right, the words of the paper, proof and consequence."""
    subject = typeset(erratum.subject)
    yield f"**{subject[:1].upper()}{subject[1:]}** ({typeset(erratum.place)})."
    yield f"Printed: {typeset(erratum.printed)}. Right: **{typeset(erratum.right)}**."
    yield ""
    if erratum.quotation:
        yield f"> „{erratum.quotation}“"
        yield ">"
        yield f"> “{erratum.translation}”"
        yield ""
    yield typeset(erratum.reasons()) + f" Shown by `{erratum.command}`."
    yield ""


def write_table(errata: Sequence[Erratum]) -> Iterator[str]:
    """Yield the lines of a table of errata, and the commands that show them."""
    yield "| place | printed | right | why |"
    yield "|---|---|---|---|"
    for one in errata:
        yield "| " + " | ".join(typeset(text) for text in (f"{one.place}: {one.subject}", one.printed, one.right, one.proof)) + " |"
    yield ""
    commands = list(dict.fromkeys(one.command for one in errata))
    yield "Shown by " + " and ".join(f"`{command}`" for command in commands) + "."


def write_correct_statements() -> str:
    """Return the section on what looks like an error and is none."""
    comparison = compare_with_paper()
    roots = {number.quantity: number.recomputed for number in comparison.numbers}
    closed, exact = comparison.wheels[-1], comparison.wheels[1]
    lost = -net_work(PAPER_ENGINE) / PAPER_ENGINE.full_pressure_work
    closing = closed_cycle(PAPER_ENGINE).load_pressure / PAPER_ENGINE.atmospheric_pressure
    extremes = energy_fluctuation(PAPER_ENGINE)
    slowest, fastest = (math.degrees(angle) for angle in (extremes.slowest_angle, extremes.fastest_angle))
    inner, middle, outer = hanger_offsets()
    forces = [(one.printed, one.recomputed) for one in compare_with_dubois().table if one.cause is None]
    slide_rule = max(abs(printed / recomputed - 1) for printed, recomputed in forces)
    shift = max(abs(math.degrees(row.shift)) for row in gm.valve_timing("slide_valve_30").rows)
    return f"""\
## What is no error

- **Redtenbacher's data do not close the cycle.** With a pump as large as the expansion cylinder and a load R of 0.4 atmospheres the
  shaft loses {lost:.4f} A p L in every stroke. The paper says that the ratio of both areas is "nahe" (nearly) 1, and the load that closes
  the cycle, {closing:.3f} atmospheres, rounds to 0.4. A periodic motion needs one of the two exactly; with this load the flywheel must have
  {closed.inertia:.0f} kg m² in place of {exact.inertia:.0f} kg m² (`governor-mechanism design flywheel`).
- **Roots of 3° and 95°.** With the rounded constant 0.25 of the paper they are {roots["root of (61)"]:.2f}° and
  {roots["root of (63)"]:.2f}°, with the exact one {slowest:.2f}° and {fastest:.2f}°. The sum of the bracket hardly depends on them:
  {comparison.terms[-2].recomputed:.5f} at the rounded angles, {sum(comparison.exact_terms):.5f} at the exact ones.
- **Zehnder's insensitivity** δ = W/(P + Q) takes the mean of the two limits of speed for the speed of rest, as he says. Exactly the
  limits are ω √(1 ± δ).
- **Zehnder's case of higher speeds in the middle positions** than at both ends cannot occur with the linkage of his Fig. 1: the speed of
  rest has a minimum there, never a maximum. Another linkage may have it.
- **Dubois' arm b** of 170 mm, with which "in der Mittellage" (in the middle position) its end is on the axis: the
  middle between its end positions, {inner:.2f} mm before and {-outer:.2f} mm beyond the axis, is
  {abs(inner + outer) / 2:.2f} mm from it, and so the hangers are symmetric, which is his aim. With the bell crank in
  its own middle position the end is {-middle:.2f} mm beyond the axis.
- **The other {len(forces)} forces of Dubois' table 2** differ from his formula by at most
  {100 * slide_rule:.2f} %, as read from a slide rule.
- **A stress of 4100 kgf/cm²** is Dubois' rounding of 346 × 4 / 0.338 = {346 * 4 / 0.338:.0f} kgf/cm² to two digits.
- **Dubois' comparison of 10 % with 56 %** is that of two governors of different size. It holds with 9 % in place of 10 %.
- **The error term at l : r = 30**, of which Müller-Melchiors says that it can no longer be detected, shifts the events by at most
  {shift:.2f}° (`governor-mechanism run slide_valve_30 --no-film --verbose`).

The papers also give advice on governing. `governor-mechanism regulation rules` tests eight rules of theirs on a simulated engine.
"""


def hanger_offsets() -> tuple[float, float, float]:
    """Return the distances of the end of Dubois' arm b from the axis (mm) at the inner end, in the middle and at the outer end."""
    governor, swing = PAPER_GOVERNOR, PAPER_INPUTS.swing
    inner, middle, outer = (
        1e3 * (governor.fulcrum_radius - governor.sleeve_arm * math.sin(governor.angle + lever)) for lever in (swing, 0.0, -swing)
    )
    return inner, middle, outer


def typeset(text: str) -> str:
    """Return a plain text with Greek letters, superscripts, subscripts, degrees and minus signs."""
    for name, letter in GREEK.items():
        text = re.sub(rf"\b{name}(?=\b|_)", letter, text)
    text = re.sub(r"\bw(?=[\d_^' )])", "ω", text)
    text = re.sub(r"\^(-?\d)", lambda match: match[1].translate(SUPERSCRIPTS), text)
    text = re.sub(r"(?<=[ωρξxcya])_?(\d)(?!\d|\.)", lambda match: match[1].translate(SUBSCRIPTS), text)
    text = re.sub(r"\b(kg m|kgf s|kg f s)2\b", r"\1²", text)
    text = re.sub(r"(?<=\d) deg\b", "°", text)
    text = re.sub(r" x (?=[\d(.])", " × ", text)
    text = re.sub(r"(?<![\w)])-(?=\d)", "−", text)
    return text.replace(" - ", " − ").replace("|", "\\|")


def main() -> None:
    """Write the page and the pictures."""
    (FOLDER / "index.md").write_text(write_page(), encoding="utf-8")
    for paper in Paper:
        draw_erratum(paper).save(FOLDER / f"{paper}.png")


if __name__ == "__main__":
    main()
