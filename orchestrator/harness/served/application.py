"""The local process: a page, and requests of it, which one thread answers with the session.

Only this machine is answered: the address is 127.0.0.1, other names of a host are refused, and a request that does something
carries JSON, which a page of another origin cannot send without being asked first.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from importlib import resources
from typing import Any

from ....components.core.errors import BadInput, StepFailed
from ...scene.scene import Scene
from ...views.data import library
from ..charts.style import axis, layout
from ..report.page import asset
from .held import HeldScene

HOSTS = ["127.0.0.1", "localhost"]


def application(scene: Scene, held: HeldScene, thread: Executor) -> Any:
    """The ASGI application of a held scene. thread: the one that uses its units. Raises `BadInput` where Starlette is missing."""
    starlette = library("starlette.applications", "explore", "starlette")
    from starlette.middleware import Middleware
    from starlette.middleware.trustedhost import TrustedHostMiddleware
    from starlette.responses import HTMLResponse, JSONResponse, Response
    from starlette.routing import Route

    actions: dict[str, Callable[..., Any]] = {
        "description": held.description,
        "begin": held.begin,
        "move": held.move,
        "advance": held.advance,
        "present": held.present,
        "errors": held.errors,
    }

    async def answered(call: Callable[[], Any]) -> tuple[Any, int]:
        try:
            return await asyncio.get_running_loop().run_in_executor(thread, call), 200
        except (BadInput, StepFailed, TypeError) as error:
            return {"error": str(error)}, 422

    async def act(request: Any) -> Any:
        if request.headers.get("content-type") != "application/json":
            return JSONResponse({"error": "expected application/json"}, 415)
        action = actions.get(request.path_params["action"])
        if action is None:
            return JSONResponse({"error": f"expected one of {', '.join(actions)}"}, 404)
        arguments = await request.json()
        return JSONResponse(*await answered(lambda: action(**arguments)))

    async def file(request: Any) -> Any:
        suffix = f".{request.path_params['suffix']}"
        content, status = await answered(lambda: held.file(suffix))
        if status != 200:
            return JSONResponse(content, status)
        name = {"content-disposition": f'attachment; filename="signals{suffix}"'}
        return Response(content, media_type="application/octet-stream", headers=name)

    page = HTMLResponse(page_of(scene))
    plotly = Response(library("plotly.offline", "explore", "plotly").get_plotlyjs(), media_type="text/javascript")
    routes = [
        Route("/", lambda _: page),
        Route("/plotly.min.js", lambda _: plotly),
        Route("/{action:str}", act, methods=["POST"]),
        Route("/signals.{suffix:str}", file),
    ]
    return starlette.Starlette(routes=routes, middleware=[Middleware(TrustedHostMiddleware, allowed_hosts=HOSTS)])


def page_of(scene: Scene) -> str:
    """The page, which asks for all else."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    from ..report.page import as_json

    environment = Environment(loader=PackageLoader(__package__, "."), autoescape=True, undefined=StrictUndefined)
    environment.filters["json"] = as_json
    plain: Mapping[str, Any] = {"height": 230, "showlegend": True, "margin": {"l": 70, "r": 16, "t": 10, "b": 40}}
    return environment.get_template("page.html").render(
        title=scene.title or scene.name,
        drawing=str(scene.show()),
        css=asset("page.css") + _asset("served.css"),
        script=asset("bands.js") + _asset("served.js"),
        layout=layout(**plain, xaxis=axis("time, s"), yaxis=axis("", grid=True)),
    )


def _asset(name: str) -> str:
    return (resources.files(__package__) / name).read_text(encoding="utf-8")


def serve(scene: Scene, port: int, ready: Callable[[str], None]) -> None:
    """Answer on 127.0.0.1 until the process is interrupted. port: 0 for a free one.  ready: is told the address.

    Raises `BadInput` where Starlette or Uvicorn is missing, or the port is taken.
    """
    import socket

    uvicorn = library("uvicorn", "explore")
    with socket.socket() as listening, ThreadPoolExecutor(1) as thread:
        try:
            listening.bind(("127.0.0.1", port))
        except OSError as error:
            raise BadInput("--port", str(port), "a port that is free", f"{error.strerror}.") from None
        held = HeldScene(scene)
        served = application(scene, held, thread)
        listening.listen()  # a browser that is opened at once is answered as soon as the server runs
        ready(f"http://127.0.0.1:{listening.getsockname()[1]}/")
        try:
            uvicorn.Server(uvicorn.Config(served, log_level="warning", lifespan="off")).run(sockets=[listening])
        finally:
            thread.submit(held.close).result()
