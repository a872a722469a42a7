"""A page in Debian's Chromium without a window, told what to do through its debugging pipe."""

import json
import os
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

FLAGS = (
    "--headless=new --no-sandbox --disable-gpu --hide-scrollbars --no-first-run "
    "--disable-background-networking --disable-component-update --disable-dev-shm-usage "
    "--remote-debugging-pipe"
)
COMPLAINTS = ("Log.entryAdded", "Runtime.consoleAPICalled", "Runtime.exceptionThrown")


@dataclass
class Visit:
    """What happened while a page was open: every request, and every error or warning."""

    requests: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)
    answers: dict[str, Any] = field(default_factory=dict)


class Browser:
    """Messages are JSON that end in a zero byte, on file descriptors 3 and 4 of the browser."""

    def __init__(self, program: str, profile: str) -> None:
        theirs_in, self._write = os.pipe()
        self._read, theirs_out = os.pipe()
        pipes = f"3<&{theirs_in} 4>&{theirs_out}"
        command = f'exec "$0" {FLAGS} --user-data-dir="$1" about:blank {pipes}'
        self.process = subprocess.Popen(
            ["bash", "-c", command, program, profile], pass_fds=(theirs_in, theirs_out),
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(theirs_in)
        os.close(theirs_out)
        self._number, self._rest = 0, b""
        self._waiting: list[dict[str, Any]] = []

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self._read)
        os.close(self._write)

    def visit(self, page: Path, width: int, questions: dict[str, str], dark: bool) -> Visit:
        """Open a file at a width in pixels; `questions` are expressions of JavaScript."""
        seen, scheme = Visit(), "dark" if dark else "light"
        target = self._ask("Target.createTarget", url="about:blank")["targetId"]
        session = self._ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for part in ("Page", "Network", "Runtime", "Log"):
            self._ask(f"{part}.enable", session)
        self._ask("Emulation.setDeviceMetricsOverride", session, width=width, height=900,
                  deviceScaleFactor=1, mobile=width < 500)  # fmt: skip
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self._ask("Emulation.setEmulatedMedia", session, features=features)
        self._waiting.clear()
        self._ask("Page.navigate", session, url=page.resolve().as_uri())
        while not any(m.get("method") == "Page.loadEventFired" for m in self._waiting):
            self._waiting.append(self._receive())
        for name, text in questions.items():
            answer = self._ask(
                "Runtime.evaluate", session, expression=text, returnByValue=True, awaitPromise=True
            )
            seen.answers[name] = answer["result"].get("value")
        for message in self._waiting:
            method, params = message.get("method"), message.get("params", {})
            if method == "Network.requestWillBeSent":
                seen.requests.append(params["request"]["url"])
            elif method in COMPLAINTS:
                seen.complaints.append(json.dumps(params))
        self._waiting.clear()
        self._ask("Target.closeTarget", targetId=target)
        return seen

    def _ask(self, method: str, session: str = "", **params: Any) -> Any:
        self._number += 1
        message = {"id": self._number, "method": method, "params": params}
        message |= {"sessionId": session} if session else {}
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while (answer := self._receive()).get("id") != self._number:
            self._waiting.append(answer)
        assert "error" not in answer, answer
        return answer["result"]

    def _receive(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            more = os.read(self._read, 1 << 16)
            assert more, "the browser has ended"
            self._rest += more
        text, self._rest = self._rest.split(b"\0", 1)
        return dict(json.loads(text))
