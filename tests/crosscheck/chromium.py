"""A page in Debian's Chromium without a window, told what to do through its debugging pipe."""

import json
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any


def found() -> str | None:
    """The browser's path, None without one."""
    return shutil.which("chromium") or shutil.which("chromium-browser")


@dataclass
class Visit:
    """What happened while a page was open: every request, and every error or warning."""

    requests: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)
    answers: dict[str, Any] = field(default_factory=dict)


class Browser:
    """Messages are JSON that end in a zero byte, on file descriptors 3 and 4 of the browser."""

    def __init__(self, program: str) -> None:
        self._profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        to_read, self._write = os.pipe()
        self._read, to_write = os.pipe()

        def place() -> None:
            # Moved out of the way first: either of them may itself be 3 or 4.
            high, higher = os.dup(to_read), os.dup(to_write)
            while min(high, higher) < 5:
                high, higher = os.dup(high), os.dup(higher)
            os.dup2(high, 3)
            os.dup2(higher, 4)

        self._process = subprocess.Popen(
            [
                program, "--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                "--no-first-run", "--disable-background-networking", "--disable-component-update",
                "--disable-dev-shm-usage", "--remote-debugging-pipe",
                f"--user-data-dir={self._profile.name}", "about:blank",
            ],
            preexec_fn=place,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(to_read)
        os.close(to_write)
        self._number = 0
        self._waiting: list[dict[str, Any]] = []
        self._rest = b""

    def __enter__(self) -> "Browser":
        return self

    def __exit__(
        self, kind: type | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.kill()
        self._process.wait()
        os.close(self._read)
        os.close(self._write)
        self._profile.cleanup()

    def visit(
        self, page: Path, width: int, questions: dict[str, str], dark: bool = False,
        media: str = "screen",
    ) -> Visit:  # fmt: skip
        """Open a file at a width in pixels; `questions` are expressions of JavaScript.

        media: "screen" or "print".
        """
        seen = Visit()
        target = self._ask("Target.createTarget", {"url": "about:blank"}, None)["targetId"]
        attach = {"targetId": target, "flatten": True}
        session = self._ask("Target.attachToTarget", attach, None)["sessionId"]
        for part in ("Page", "Network", "Runtime", "Log"):
            self._ask(f"{part}.enable", {}, session)
        metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500}
        self._ask("Emulation.setDeviceMetricsOverride", metrics, session)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self._ask("Emulation.setEmulatedMedia", {"media": media, "features": [scheme]}, session)
        self._waiting.clear()
        self._ask("Page.navigate", {"url": page.resolve().as_uri()}, session)
        while not any(m.get("method") == "Page.loadEventFired" for m in self._waiting):
            self._waiting.append(self._receive())
        for name, expression in questions.items():
            answer = self._ask(
                "Runtime.evaluate", {"expression": expression, "returnByValue": True}, session
            )
            seen.answers[name] = answer["result"].get("value")
        for message in self._waiting:
            method, params = message.get("method"), message.get("params", {})
            if method == "Network.requestWillBeSent":
                seen.requests.append(params["request"]["url"])
            elif method == "Log.entryAdded":
                seen.complaints.append(params["entry"]["text"])
            elif method in ("Runtime.consoleAPICalled", "Runtime.exceptionThrown"):
                seen.complaints.append(json.dumps(params))
        self._waiting.clear()
        self._ask("Target.closeTarget", {"targetId": target}, None)
        return seen

    def _ask(self, method: str, params: dict[str, Any], session: str | None) -> dict[str, Any]:
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": params}
        if session is not None:
            message["sessionId"] = session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                result: dict[str, Any] = answer["result"]
                return result
            self._waiting.append(answer)

    def _receive(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            more = os.read(self._read, 1 << 16)
            assert more, "the browser has ended"
            self._rest += more
        text, self._rest = self._rest.split(b"\0", 1)
        message: dict[str, Any] = json.loads(text)
        return message
