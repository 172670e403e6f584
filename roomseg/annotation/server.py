"""The local server of the page: loopback only, Host and origin checked on every request.

A page of another site that the browser has open must not reach the maps: it may send
requests to this machine, under any name that its owner lets point here. So a request counts
only if it is addressed to this server by a name of the loopback, and comes from no other
page. Paths name maps and nodes by number; no file is opened by what a browser says.
"""

from __future__ import annotations

from asyncio import Future
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from bokeh.document import Document
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from numpy.typing import NDArray
from tornado import httputil, netutil, web
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop
from tornado.routing import Router

from dataset import MapFile, RoomsegError
from roomseg.annotation.page import AnnotationPage
from roomseg.annotation.session import Annotation, Confirmation
from roomseg.panorama import PanoramaParameters, Unfolding

__all__ = ["AnnotationServer"]

ADDRESS = "127.0.0.1"
NAMES = ("127.0.0.1", "localhost")
SITES = (None, "same-origin", "none")
"""What a browser may say of where a request comes from."""


class AnnotationServer:
    """Serves the pages of some maps until it is stopped.

    Parameters
    ----------
    annotations : sequence of Annotation
    port : int
        0: any that is free.

    Raises
    ------
    RoomsegError
        If the port is taken.
    """

    def __init__(self, annotations: Sequence[Annotation], port: int = 0) -> None:
        self._annotations = tuple(annotations)
        self._images = [NodeImages(annotation) for annotation in annotations]
        try:
            sockets = netutil.bind_sockets(port, ADDRESS)
        except OSError as error:
            raise RoomsegError(
                f"--port {port}: cannot be used ({error.strerror}), expected a free one"
            ) from error
        self.port: int = sockets[0].getsockname()[1]
        hosts = [f"{name}:{self.port}" for name in NAMES]
        self._pool = ThreadPoolExecutor(1)
        self._clusterings = [Clustering(annotation, self._pool) for annotation in annotations]
        app = BokehTornado(
            {f"/map{index}": self._page(index) for index in range(len(annotations))},
            extra_websocket_origins=hosts,
            extra_patterns=[
                (r"/", web.RedirectHandler, {"url": "/map0", "permanent": False}),
                (
                    r"/image/(\d{1,4})/(\d{1,8})/(fisheye|panorama)\.png",
                    ImageHandler,
                    {"images": self._images},
                ),
            ],
            use_index=False,
            websocket_max_message_size_bytes=2**20,
        )
        server = HTTPServer(Guard(app, frozenset(hosts)))
        server.add_sockets(sockets)
        self._server = BaseServer(IOLoop.current(), app, server)

    @property
    def url(self) -> str:
        """Where the first map's page is."""
        return f"http://{ADDRESS}:{self.port}/"

    def run(self) -> None:
        """Serve until a KeyboardInterrupt."""
        self._server.start()
        for clustering in self._clusterings:
            clustering.follow()
        try:
            self._server.io_loop.start()
        finally:
            self._server.stop(wait=False)
            self._pool.shutdown(wait=False, cancel_futures=True)
            for images in self._images:
                images.close()

    def _page(self, index: int) -> Callable[[Document], None]:
        others = tuple(
            (annotation.path.name, f"/map{number}")
            for number, annotation in enumerate(self._annotations)
            if number != index
        )

        def fill(document: Document) -> None:
            images = self._images[index]
            page = AnnotationPage(self._annotations[index], f"/image/{index}", images.done, others)
            page.show_in(document)

        return fill


class Clustering:
    """Lets the clustering follow an annotation in another thread, edits in between left out."""

    def __init__(self, annotation: Annotation, pool: ThreadPoolExecutor) -> None:
        self._annotation = annotation
        self._pool = pool
        self._busy = False
        annotation.watchers.append(self.follow)

    def follow(self) -> None:
        """Cluster what is drawn now, if it is not yet; later, if another is being clustered."""
        if self._annotation.confirmation is None and not self._busy:
            self._busy = True
            loop = IOLoop.current()
            loop.add_future(
                loop.run_in_executor(self._pool, self._annotation.pending()), self._settle
            )

    def _settle(self, done: Future[Confirmation]) -> None:
        self._busy = False
        self._annotation.settle(done.result())
        self.follow()


class NodeImages:
    """Images of a map's nodes as PNG, read when they are asked for."""

    def __init__(self, annotation: Annotation) -> None:
        self._file = MapFile(annotation.path)
        self.done: NDArray[np.bool_] = self._file.done
        self._unfold = Unfolding.of(self._file.topomap.camera, PanoramaParameters())
        self.png = lru_cache(maxsize=256)(self._png)

    def _png(self, node: int, view: str) -> bytes:
        image = self._file.image(node)
        pixels = self._unfold(image) if view == "panorama" else image
        return bytes(cv2.imencode(".png", pixels)[1])

    def close(self) -> None:
        """Let the map file go."""
        self._file.close()


class ImageHandler(web.RequestHandler):
    """Answers with the image of a node."""

    def initialize(self, images: Sequence[NodeImages]) -> None:
        """Take the maps' images."""
        self._images = images

    def get(self, number: str, node: str, view: str) -> None:
        """Send it, or 404 if there is none."""
        index, at = int(number), int(node)
        if index >= len(self._images) or at >= len(self._images[index].done):
            raise web.HTTPError(404)
        if not self._images[index].done[at]:
            raise web.HTTPError(404)
        self.set_header("Content-Type", "image/png")
        self.finish(self._images[index].png(at, view))


class Guard(Router):
    """Lets only requests from this server's own pages through to the application."""

    def __init__(self, app: BokehTornado, hosts: frozenset[str]) -> None:
        self._app = app
        self._hosts = hosts
        self._origins = frozenset(f"http://{host}" for host in hosts)
        self._refusal = web.Application([(r".*", Refusal)])

    def find_handler(self, request: httputil.HTTPServerRequest, **kwargs: Any) -> Any:
        """Choose who answers."""
        app = self._app if self._is_own(request) else self._refusal
        return app.find_handler(request, **kwargs)

    def _is_own(self, request: httputil.HTTPServerRequest) -> bool:
        headers = request.headers
        origin = headers.get("Origin")
        return (
            headers.get_list("Host") in [[host] for host in self._hosts]
            and (origin is None or origin in self._origins)
            and headers.get("Sec-Fetch-Site") in SITES
        )


class Refusal(web.RequestHandler):
    """Answers 403."""

    def prepare(self) -> None:
        """Refuse, whatever the method."""
        self.set_status(403)
        self.finish("refused: open the page by the address that roomseg annotate has printed\n")
