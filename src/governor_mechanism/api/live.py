"""A mechanism under the hand, from Python."""

import governor_mechanism as gm
from governor_mechanism.api.scenes import as_scene
from governor_mechanism.errors import MechanismError


def open(scene: gm.SceneSource | None = None, *, port: int = 0, browser: bool = True) -> None:
    """Open a scene in the browser, where its quantities are changed and its points dragged; it ends with an interrupt.

    Each change is answered by a certified run. The page is served to this machine alone, under an address that no other page knows.

    Parameters
    ----------
    scene
        A scene, the path of a file, or the name of a shipped scene; a list to choose from if None.
    port
        Port of the page; 0 takes any free one.
    browser
        Whether the page is opened; its address is printed anyway.

    Raises
    ------
    MechanismError
        If the extra `live` is not installed, the scene cannot be run, or the port is taken.
    """
    try:
        from governor_mechanism.live.server import serve
    except ImportError as error:
        text = f"the live page needs starlette, uvicorn and websockets ({error}); install the extra: pip install 'governor-mechanism[live]'"
        raise MechanismError(text) from None
    serve(None if scene is None else as_scene(scene), port, opens_browser=browser, tell=lambda address: print(f"{address}\nCtrl-C ends it"))
