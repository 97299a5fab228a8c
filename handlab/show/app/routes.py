"""The addresses beside the socket: page, program text, the static scene, exports."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aiohttp.web import Request, Response, RouteDef, StreamResponse

    from handlab.show.app.server import App


TITLE = "handlab"
ICON = (
    "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 32 32'><path d='M9 29V15l-4-5 3-2 5 6V4h3v9l1-11h3v11l2-10h3l-2 11 3-7 2 1-4 "
    "13-2 8z' fill='#E2B8A2' stroke='#7A4A3A'/></svg>"
)
LOOK = "font:18px/1.5 system-ui,sans-serif;color:#1f2933;text-align:center;margin-top:40vh"
WAITING = f"<p style='{LOOK}'>The hand is on its way ...</p>"

# trame takes the key out of the address bar, where a projector would show it; a reload finds it in the tab's own storage.
# Without ``sessionURL`` trame would first ask for a launcher that is not there.
BEFORE_TRAME = """
const query = new URLSearchParams(location.search);
sessionStorage.setItem("handlab-key", query.get("secret"));
if (query.has("fit")) sessionStorage.setItem("handlab-fit", query.get("fit")); // the room of the picture that the command was given
query.delete("fit");
query.set("sessionURL", location.protocol.replace("http", "ws") + "//" + location.host + "/ws");
history.replaceState({}, "", "?" + query);
"""
REFUSED = f"""<!doctype html><meta charset="utf-8"><title>{TITLE}</title><p style="{LOOK}">This address lacks the key of this run:
open the one that <code>handlab</code> printed.</p><script>
const kept = sessionStorage.getItem("handlab-key");
if (location.search) sessionStorage.removeItem("handlab-key");
else if (kept) location.replace("index.html?secret=" + encodeURIComponent(kept));
</script>"""

USED = "handlab: this address opened the page once already; open the one that handlab printed.\n"


def routes(app: App) -> list[RouteDef]:
    """What is added to trame's own addresses; these come first."""
    from aiohttp import web

    from handlab.show.app.server import STATIC

    async def root(request: Request) -> Response:
        if "ticket" in request.query:
            if not app.guard.redeem(request.query["ticket"]):
                return web.Response(status=403, text=USED)
            raise web.HTTPFound(f"index.html?secret={app.guard.key}{app.opens}")
        raise web.HTTPFound(f"index.html?{request.query_string}" if request.query_string else "index.html")

    async def index(request: Request) -> Response:
        if not app.guard.knows(request.query.get("secret")):
            return web.Response(status=403, text=REFUSED, content_type="text/html")
        return web.Response(text=page(), content_type="text/html")

    async def waiting(request: Request) -> Response:
        return web.Response(text=WAITING, content_type="text/html")

    async def icon(request: Request) -> Response:
        return web.Response(text=ICON, content_type="image/svg+xml")

    async def scene(request: Request) -> Response:
        session = await app.session()
        return web.Response(body=session.scene(), content_type="application/octet-stream")

    async def file(request: Request) -> StreamResponse:
        word = request.match_info["word"]
        made = app.files.find(word)
        if made is None:
            raise web.HTTPNotFound(text="handlab: this file was fetched already; export it again.\n")
        try:
            body = await asyncio.to_thread(made.path.read_bytes)
        finally:
            app.files.drop(word)
        return web.Response(body=body, content_type=made.mime, headers={"Content-Disposition": f'attachment; filename="{made.name}"'})

    async def static(request: Request) -> StreamResponse:
        name = request.match_info["name"]
        if name not in {path.name for path in STATIC.iterdir() if path.is_file()}:
            raise web.HTTPNotFound
        return web.FileResponse(STATIC / name)

    return [
        web.get("/", root),
        web.get("/index.html", index),
        web.get("/loading.tpl", waiting),
        web.get("/handlab/icon.svg", icon),
        web.get("/handlab/static/{name}", static),
        web.get("/handlab/data/scene", scene),
        web.get("/handlab/data/frames", app.live.frames.page),
        web.get("/handlab/data/file/{word}", file),
        web.post("/handlab/data/fit/{word}", app.own_hands.ask),
        web.post("/handlab/data/paint/{word}", app.paint_rooms.ask),
    ]


def page() -> str:
    """trame's page under our name. Its first script keeps the key for a reload and says where the socket is."""
    from trame_client.module.vue3 import www

    text = (Path(www) / "index.html").read_text(encoding="utf-8")
    begin, end = text.index("<title>"), text.index("</title>")
    text = text[:begin] + f"<title>{TITLE}" + text[end:]
    text = text.replace('<link rel="icon" href="logo.png" />', '<link rel="icon" href="handlab/icon.svg" />')
    return text.replace("<head>", f"<head><script>{BEFORE_TRAME}</script>", 1)
