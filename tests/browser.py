"""Pages in a headless Chromium: a page that is served acts on itself, as a test says, and reports what it found. And their links."""

import functools
import http.server
import importlib.util
import json
import os
import queue
import re
import shutil
import subprocess
import threading
from html import unescape
from pathlib import Path
from urllib.parse import unquote

from mpmverify.reports.pdf import BROWSERS

BROWSER = next(filter(None, map(shutil.which, BROWSERS)), None)
AXE = importlib.util.find_spec("axe_playwright_python")
WATCH = """<script>
const faults = [];
let graphics = false;
addEventListener("error", (event) => faults.push(String(event.message)));
addEventListener("unhandledrejection", (event) => faults.push(String(event.reason)));
const plain = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, choices) {  // emulated graphics are good enough for a test
  const context = plain.call(this, kind, { ...choices, failIfMajorPerformanceCaveat: false });
  if (kind === "webgl2" && context) graphics = true;
  return context;
};
WebGL2RenderingContext.prototype.getExtension = () => null;  // no page can tell then that they are emulated
console.error = (...parts) => faults.push(parts.join(" "));
</script>"""


THIN = """
  const kinds = new Map(), numbers = new Map(), cut = [];
  const kind = (node) => {  // nodes of one kind have the same tag, attributes, looks, and kinds of nodes within
    if (!numbers.has(node)) {
      const told = ["class", "style", "role", "alt", "tabindex", "type", "aria-hidden", "aria-label"];
      const said = [...node.attributes].map(({ name, value }) => (told.includes(name) ? name + value : name));
      if (!node.textContent.trim()) said.push("empty");
      const within = node.localName === "math" ? [] : [...new Set([...node.children].map(kind))];
      const text = [node.localName, ...said.sort(), ...within.sort()].join(" ");
      if (!kinds.has(text)) kinds.set(text, kinds.size);
      numbers.set(node, kinds.get(text));
    }
    return numbers.get(node);
  };
  const thin = (parent) => {
    const seen = new Map();
    for (const child of [...parent.children]) {
      seen.set(kind(child), (seen.get(kind(child)) ?? 0) + 1);
      if (seen.get(kind(child)) <= 2) {
        thin(child);
      } else {
        cut.push([child, parent, child.nextSibling]);
        child.remove();
      }
    }
  };
  thin(document.body);
"""
"""Leaves two of each kind among the children of a node: axe-core takes half a minute for a page of sixty thousand."""
CHECK = """
  for (const folded of [...document.querySelectorAll("details")].slice(0, 12)) folded.open = true;
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  const all = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];
  const runOnly = dark ? { type: "rule", values: ["color-contrast"] } : all;  // a dark ground changes colours alone
  const { violations } = await axe.run(document, { runOnly, resultTypes: ["violations"] });
  for (const [child, parent, next] of cut.reverse()) parent.insertBefore(child, next);
  const serious = violations.filter(({ impact }) => impact === "serious" || impact === "critical");
  return { dark, serious: serious.map(({ id, nodes }) => `${id}: ${nodes[0].html.slice(0, 200)} (${nodes.length})`) };
"""


class Desk(http.server.SimpleHTTPRequestHandler):
    """Serves a report, and receives what the page reports of itself: a browser draws nothing while it only dumps a page."""

    outcomes: "queue.Queue[dict]"
    missing: list[str]

    def do_POST(self) -> None:
        self.outcomes.put(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
        self.send_response(204)
        self.end_headers()

    def send_error(self, *arguments: object, **_: object) -> None:
        self.missing.append(self.path)
        super().send_error(*arguments)

    def log_message(self, *_: object) -> None:
        pass


def acted(page: Path, report: Path, act: str, profile: Path, *options: str, window: str = "1280,900") -> dict:
    """Open a page of a report in a browser and return what it found.

    Parameters
    ----------
    page, report : Path
        The page, and the folder of the report.
    act : str
        Body of an asynchronous function that returns an object; it may use `frame` and `pause`, which wait for one and three frames.
    profile : Path
        Folder of the browser.
    *options : str
        Further options of the browser.
    window : str
        Width and height.

    Returns
    -------
    dict
        The object, with the errors of the scripts as `faults`, whether WebGL was used as `graphics`, and the files that the page asked
        for in vain as `missing`.
    """
    place = page.with_name(f"acted-{os.getpid()}-{page.name}")  # other processes may look at the same page
    script = f"""<script>
addEventListener("load", async () => {{
  const frame = () => new Promise((done) => requestAnimationFrame(done));
  const pause = async () => {{ for (let k = 0; k < 3; k += 1) await frame(); }};
  let outcome = {{}};
  try {{
    outcome = await (async () => {{ {act} }})();
  }} catch (error) {{
    faults.push(String(error));
  }}
  await fetch("/outcome", {{ method: "POST", body: JSON.stringify({{ ...outcome, faults, graphics }}) }});
}});
</script>"""
    text = page.read_text(encoding="utf-8")
    place.write_text(text.replace("<head>", f"<head>{WATCH}").replace("</body>", f"{script}</body>"), encoding="utf-8")
    desk = type("DeskOfOne", (Desk,), {"outcomes": queue.Queue(), "missing": []})
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(desk, directory=str(report))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        command = [str(BROWSER), "--headless=new", "--no-sandbox", "--no-proxy-server", f"--user-data-dir={profile}"]
        address = f"http://127.0.0.1:{server.server_port}/{place.relative_to(report).as_posix()}"
        browser = subprocess.Popen(
            [*command, f"--window-size={window}", "--remote-debugging-port=0", *options, address],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            return desk.outcomes.get(timeout=120) | {"missing": desk.missing}
        finally:
            browser.terminate()
            browser.wait(timeout=20)
            server.shutdown()
            place.unlink()


def examined(page: Path, report: Path, scheme: str, profile: Path, act: str = "return {};", window: str = "1280,900") -> dict:
    """Look at a page by axe-core, where it is installed, two of each kind of what it repeats, and act on the whole page then.

    Parameters
    ----------
    page, report, act, profile, window
        As `acted` takes them.
    scheme : str
        "light" or "dark", the ground of the page.

    Returns
    -------
    dict
        What `acted` returns, with what axe-core finds serious as `serious`.
    """
    code, look = "", 'return { serious: [], dark: matchMedia("(prefers-color-scheme: dark)").matches };'
    if AXE:
        code, look = Path(AXE.submodule_search_locations[0], "axe.min.js").read_text(encoding="utf-8"), THIN + CHECK
    both = f"{code}; const look = async () => {{ {look} }}; const act = async () => {{ {act} }};"
    dark = ["--force-dark-mode", "--blink-settings=preferredColorScheme=0"] if scheme == "dark" else []
    found = acted(page, report, both + "return { ...(await look()), ...(await act()) };", profile, *dark, window=window)
    assert found["dark"] == (scheme == "dark")
    return found


def broken_links(page: Path, report: Path) -> list[str]:
    """Links of a page that leave the results, or lead nowhere."""
    broken = []
    for href in re.findall(r'(?:href|src)="([^"]*)"', page.read_text(encoding="utf-8")):
        target, _, anchor = unescape(href).partition("#")
        if re.match(r"[a-z]+:", target):
            if not target.startswith(("https://", "http://", "data:", "blob:")):
                broken.append(href)
            continue
        found = (page.parent / unquote(target)).resolve() if target else page
        leads = found.is_relative_to(report.resolve().parent) and found.exists()
        if leads and anchor and found.suffix == ".html" and "=" not in anchor:
            leads = unquote(anchor) in _identifiers(found)
        if not leads:
            broken.append(href)
    return broken


@functools.cache
def _identifiers(page: Path) -> set[str]:
    return {unescape(name) for name in re.findall(r'\bid="([^"]*)"', page.read_text(encoding="utf-8"))}
