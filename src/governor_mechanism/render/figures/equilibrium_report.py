"""All figures of the equilibria of a scene."""

from collections.abc import Mapping

from governor_mechanism.model.results.pictures import Figure
from governor_mechanism.render.figures.plates.isochronous import has_isochronous_parabolas, isochronous_figure
from governor_mechanism.studies.equilibrium_report import EquilibriumReport, GovernorForces


def equilibrium_figures(report: EquilibriumReport) -> Mapping[str, Figure]:
    """Draw speed curve, controlling force if there are balls, and Zehnder's plate for the governors that it covers.

    Result: the figures by the ends of the names of their files; none without a speed curve.
    """
    if report.curve is None:
        return {}
    figures = {"_characteristic": report.curve.plot(report.equilibria)}
    if isinstance(report.forces, GovernorForces):
        figures["_controlling_force"] = report.forces.curve.plot(report.equilibria)
    if has_isochronous_parabolas(report.scene):
        figures["_parabolas"] = isochronous_figure(report.scene)
    return figures
