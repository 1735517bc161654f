"""A page served to this machine alone, until it is stopped."""

from __future__ import annotations

import errno
from collections.abc import Callable

import panel as pn
import panel_material_ui as pmui

from toonkit._validation import refuse

HIGHEST_PORT = 65535


def serve_page(
    name: str,
    app: Callable[[], pmui.Page],
    *,
    port: int,
    show: bool,
    started: Callable[[str], None],
) -> None:
    """
    Serve a page on localhost until the process is interrupted or terminated.

    Parameters
    ----------
    name : str
        The last part of the page's address.
    app : callable
        Sets up the session of one visitor, and returns their page.
    port : int
        1 to 65535.
    show : bool
        Whether to open a browser.
    started : callable
        Called with the page's address once it can be visited.

    Raises
    ------
    ToonkitError
        If the port is none, in use, or not for this user.
    """

    def visited() -> pmui.Page:  # Panel calls functions alone: of other callables it would show the answer
        return app()

    if not 1 <= port <= HIGHEST_PORT:
        raise refuse("port", f"must be a number from 1 to {HIGHEST_PORT}", port)
    try:
        server = pn.serve(
            {name: visited},
            title={name: ""},  # that of the page, and not "Panel Application"
            port=port,
            address="localhost",
            websocket_origin=[f"localhost:{port}", f"127.0.0.1:{port}"],
            start=False,
            show=False,
            verbose=False,
        )
    except OSError as error:
        reason = "in use" if error.errno == errno.EADDRINUSE else error.strerror or error
        raise refuse(
            "port", "must be one that nothing else uses; try another", f"{port} ({reason})"
        ) from error
    server.start()
    started(f"http://localhost:{port}/{name}")
    if show:
        server.io_loop.add_callback(server.show, f"/{name}")
    server.run_until_shutdown()
