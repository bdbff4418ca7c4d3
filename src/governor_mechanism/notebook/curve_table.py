"""A speed curve as a notebook shows it."""

from governor_mechanism.notebook.html import draw_small_curve, format_html_table, format_paragraph
from governor_mechanism.statics.speed_curve import SpeedCurve
from governor_mechanism.units.constants import RPM


def speed_curve_html(curve: SpeedCurve) -> str:
    """Return a speed curve as HTML.

    Result: travel, equilibrium speeds with a small curve, the stable share, folds and poles.
    """
    has_equilibrium = curve.has_equilibrium
    rows = [("travel", "", f"{curve.coordinate_name} {curve.coordinate[0]:.6g} to {curve.coordinate[-1]:.6g} (SI)")]
    if has_equilibrium.any():
        speeds = curve.speed[has_equilibrium]
        span = f"{speeds.min() / RPM:.6g} to {speeds.max() / RPM:.6g} rpm"
        rows.append(("equilibrium speed", draw_small_curve(speeds, 0.0), span))
        rows.append(("stable", "", f"{curve.stable.sum() / has_equilibrium.sum():.1%} of the travel with an equilibrium"))
    folds = (f"{speed / RPM:.6g} rpm at {coordinate:.6g}" for coordinate, speed in curve.folds)
    rows += [("jumps at", "", text) for text in folds]
    rows += [("no equilibrium beyond", "", f"{pole:.6g}") for pole in curve.poles]
    return format_paragraph("Equilibrium speed over the travel", is_bold=True) + format_html_table((), rows, n_text_columns=3)
