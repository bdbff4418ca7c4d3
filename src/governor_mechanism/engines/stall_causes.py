"""Why an integration stalled, as far as the scene tells: possible causes with their cures, as a sentence."""

from collections.abc import Iterator

from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.dynamics.forces.contact_modes import has_contacts
from governor_mechanism.mechanics.dynamics.forces.contacts import output_forces_of
from governor_mechanism.model.force_elements import Force, Torque
from governor_mechanism.model.joints import RotationalDriver, TranslationalDriver
from governor_mechanism.model.scene import Scene


def describe_stall(scene: Scene, status: IntegrationStatus) -> str:
    """Return why an integration stalled, from its status and from what the scene has."""
    if status == IntegrationStatus.ENDLESS_EVENTS:
        return "contacts change between rest and motion without end; change the restitution of a stop, add a dashpot, or try engine impulse"
    return f"its steps became too small, as where {', or '.join(_possible_causes(scene))}"


def _possible_causes(scene: Scene) -> Iterator[str]:
    """Yield what in a scene can make steps too small, with its cure."""
    mechanism = scene.mechanism
    if any(isinstance(joint, RotationalDriver | TranslationalDriver) for joint in mechanism.joints):
        yield "a driver locks the mechanism (shorten its motion)"
    if has_contacts(scene):
        yield "stops and friction jam it (widen the stops or reduce the friction)"
    if output_forces_of(scene) or any(not isinstance(element, Force | Torque) for element in mechanism.force_elements):
        yield "a spring or damper is too stiff for the masses (soften it)"
    yield "it comes to a singular configuration or to forces without bounds (change a length, a load or the start)"
