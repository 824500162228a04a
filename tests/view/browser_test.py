"""The live view in a real browser: browser_test.py AFFERENT SCENE. Skipped (77) without Chromium and Selenium.

It shows a grasp, follows, pauses, marks, and survives a restart of the hand; others are refused. A movie
fits the browser's width.
"""

import contextlib
import csv
import http.client
import http.server
import io
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import urllib.parse

from browser import By, Program, chromium, until


class Page:
    def __init__(self, browser, url):
        self.browser = browser
        browser.get(url)

    def run(self, script):
        return self.browser.execute_script(script)

    def model(self, what):
        return self.run(f"return afferentView.model.{what}")

    def until(self, script, what):
        return until(lambda: self.run(f"const {{model, shown, marks}} = afferentView; return {script}"), what)

    def press(self, key):
        self.browser.find_element(By.TAG_NAME, "body").send_keys(key)

    def text(self, name):
        return self.browser.find_element(By.ID, name).text

    def colours(self, chart):
        """How many colours the canvas of a chart has."""
        return self.run(
            f"""const canvas = document.querySelector('.chart.{chart} canvas');
            if (!canvas || !canvas.width) return 0;
            const {{data}} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
            return new Set(new Uint32Array(data.buffer)).size;"""
        )

    def expect_no_errors(self):
        # A page that looks for a server that is being started again is told that the connection failed.
        log = [each for each in self.browser.get_log("browser") if "ERR_CONNECTION_REFUSED" not in each["message"]]
        assert not log, log


def expect_grasp(browser, afferent, scene, folder):
    """The picture of a grasp appears, with the run's own values, follows and pauses."""
    out = folder / "run"
    # Twice the scene, so that a browser that is slow to start still finds it running.
    with Program(afferent, "run", scene, "--realtime", "--duration", "20", "--view", "--out", out) as program:
        page = Page(browser, program.url())
        page.until("model.last !== null", "the first data")
        assert page.text("scene") == "grasp"
        first = page.model("last")
        page.until(f"model.last > {first} + 1", "time to advance")
        page.until("shown.live && shown.range()[1] >= model.last", "the newest at the right edge")
        page.until("document.getElementById('state').textContent === 'live'", "the state")

        page.press(" ")
        held = page.run("return afferentView.shown.range()")
        paused = page.model("last")
        page.until(f"model.last > {paused} + 0.5", "data during a pause")
        assert page.run("return afferentView.shown.range()") == held
        page.until("document.getElementById('state').textContent === 'paused'", "the state")
        page.press("+")
        span = page.run("return afferentView.shown.span")
        assert span < held[1] - held[0], span
        page.press(" ")

        page.until("model.raster.events > 500", "spikes")
        for chart in ("force", "raster", "rate", "gain", "bytes"):
            until(lambda name=chart: page.colours(name) > 3, f"a picture of {chart}")

        page.press("m")
        page.press("m")
        page.until("marks.length === 2", "marks")
        rows = list(csv.DictReader(io.StringIO(page.run("return afferentView.marksAsCsv()"))))
        assert [row["mark"] for row in rows] == ["1", "2"], rows
        assert 0 < float(rows[0]["time_s"]) <= page.model("last"), rows

        page.until("model.ended || model.course > 1", "the end")
        assert program.end() == 0, program.said()
        page.until("['ended', 'reconnecting'].includes(document.getElementById('state').textContent)", "the end's state")

    # Every sample is a row of force.csv.
    by_time = {}
    with open(out / "force.csv", newline="") as file:
        for row in csv.DictReader(file):
            by_time[float(row["time_s"])] = row
    samples = page.run("const {time, estimate_n, sigma_n, rate_hz, gain, doubt} = afferentView.model.samples;"
                       "return {time, estimate_n, sigma_n, rate_hz, gain, doubt}")
    compared = 0
    for i, time_s in enumerate(samples["time"]):
        if samples["estimate_n"][i] is None:
            continue  # where the line is broken
        row = by_time[time_s]
        assert samples["doubt"][i] == row["doubt"], time_s
        for name in ("estimate_n", "sigma_n", "rate_hz", "gain"):
            assert abs(samples[name][i] - float(row[name])) <= 1e-6 * max(1, abs(float(row[name]))), (time_s, name)
        compared += 1
    assert compared > 300, compared
    # No event is lost in the bins.
    with open(out / "events.csv") as file:
        events = sum(1 for _ in file) - 1
    if page.model("unseen") == 0 and page.model("dropped") == 0:
        assert page.model("raster.events") == events, (page.model("raster.events"), events)
    page.expect_no_errors()


def expect_end(browser, afferent, scene):
    """A scene that has ended stays on view, and says so; to a page that comes later as well."""
    with Program(afferent, "view", scene, "--duration", "1") as program:
        for _ in range(2):
            page = Page(browser, program.url())
            page.until("document.getElementById('state').textContent === 'ended'", "the badge of a scene that has ended")
            assert page.model("last") > 0.8, page.model("last")
        assert "Of raw samples, last 0.5 s" in page.text("link"), page.text("link")
        assert program.process.poll() is None, program.said()
        assert program.end(signal.SIGINT) == 130, program.said()
    page.expect_no_errors()


def free_port():
    with socket.socket() as any_free:
        any_free.bind(("127.0.0.1", 0))
        return any_free.getsockname()[1]


def expect_restart(browser, afferent, folder):
    """The page goes on after the hand was started again, and after the coprocessor was."""
    env = {**os.environ, "XDG_RUNTIME_DIR": str(folder)}
    scene = folder / "s.txtpb"
    scene.write_text(
        f'name: "again" duration_s: 600 link {{ unix_socket {{ path: "{folder}/hand.sock" }} '
        "freeze_ms: 300 safe_ms: 4000 stale_ms: 1500 } "
        "hand { user { close_at_s: 0.1 close_for_s: 2 hold_for_s: 500 open_for_s: 1 effort: 0.7 } "
        "object { distance_mm: 5 stiffness_n_per_mm: 1 } }"
    )
    hand = [afferent, "hand", scene, "--view-port", free_port()]
    with Program(*hand, env=env) as first, Program(afferent, "coprocessor", scene, env=env) as coprocessor:
        url = first.url()
        page = Page(browser, url)
        page.until("model.raster && model.raster.events > 20 && model.samples.time.length > 20", "a grasp")
        page.until("model.link.grip === 'operating' && model.link.session === 'open'", "the state of the link")
        kept = list((folder / "afferent").glob("view-*"))
        assert [oct(file.stat().st_mode & 0o777) for file in kept] == ["0o600"], kept
        assert coprocessor.end(signal.SIGINT) == 130, coprocessor.said()
        page.until("model.link.session === 'none' && model.link.grip !== 'operating'", "the coprocessor's end")
        page.until("document.getElementById('link').textContent.includes('none')", "what the page says of it")
        with Program(afferent, "coprocessor", scene, env=env):
            page.until("model.link.sessions === 2 && model.link.session === 'open'", "the next session")
            assert first.end(signal.SIGINT) == 130, first.said()
            page.until("document.getElementById('state').textContent !== 'live'", "the hand's end")
            course = page.model("course")
            # The coprocessor has ended with the hand's session.
            with Program(*hand, env=env) as second, Program(afferent, "coprocessor", scene, env=env):
                assert second.url() == url
                page.until(f"model.course > {course} && model.last !== null", "the hand that was started again")
                page.until("document.getElementById('state').textContent === 'live'", "a live view")
                last = page.model("last")
                page.until(f"model.last > {last}", "time to advance")
                assert second.end(signal.SIGTERM) == 130, second.said()
    page.expect_no_errors()


def status(url, path=None, host=None, origin=None, upgrade=False):
    """What a raw request is answered with."""
    parts = urllib.parse.urlsplit(url)
    connection = http.client.HTTPConnection("127.0.0.1", parts.port, timeout=60)
    connection.putrequest("GET", path or parts.path, skip_host=True)
    connection.putheader("Host", host or parts.netloc)
    if origin:
        connection.putheader("Origin", origin)
    if upgrade:
        for name, value in {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13",
                            "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA=="}.items():
            connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse().status
    connection.close()
    return answer


def listens_at(port):
    """The addresses at which somebody on this machine listens at that port."""
    found = []
    for table in ("/proc/net/tcp", "/proc/net/tcp6"):
        for line in pathlib.Path(table).read_text().splitlines()[1:]:
            _, local, _, state = line.split()[:4]
            address, at = local.split(":")
            if state == "0A" and int(at, 16) == port:
                found.append(address)
    return found


def own_addresses():
    """Of this machine, by which another could reach it."""
    found = subprocess.run(["hostname", "-I"], capture_output=True, text=True, check=False).stdout.split()
    return [each for each in found if ":" not in each and not each.startswith("127.")]


@contextlib.contextmanager
def other_site():
    class Empty(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.end_headers()

        def log_message(self, *_):
            pass

    # A browser also connects ahead of time, and asks for nothing: that must not keep the server from ending.
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Empty)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


def expect_refusals(browser, afferent, scene):
    with Program(afferent, "view", scene) as program:
        url = program.url()
        parts = urllib.parse.urlsplit(url)
        there = f"http://{parts.netloc}"
        assert status(url) == 200
        assert status(url, host=f"localhost:{parts.port}") == 200
        assert status(url, host="hand.example") == 403
        assert status(url, host=f"hand.example:{parts.port}") == 403
        assert status(url, path="/" + "0" * 32 + "/") == 404
        assert status(url, origin="http://hand.example") == 403
        assert status(url, path=parts.path + "socket", origin="http://hand.example", upgrade=True) == 403
        assert status(url, path=parts.path + "socket", upgrade=True) == 403
        assert status(url, path=parts.path + "socket", origin=there, upgrade=True) == 101
        # A second machine would come by another address, where nobody listens.
        assert listens_at(parts.port) == [socket.inet_aton("127.0.0.1")[::-1].hex().upper()], listens_at(parts.port)
        for address in own_addresses():
            try:
                socket.create_connection((address, parts.port), timeout=1).close()
            except OSError:
                continue
            raise AssertionError(f"it answers at {address}")

        # A page of another origin on this machine, in the browser, which even knows the address.
        with other_site() as site:
            browser.get(site)
            said = browser.execute_async_script(
                f"""const done = arguments[0];
                const socket = new WebSocket('ws://{parts.netloc}{parts.path}socket');
                socket.onopen = () => done('open');
                socket.onerror = () => done('refused');"""
            )
            assert said == "refused", said
        assert any("403" in each["message"] for each in browser.get_log("browser"))
        assert program.end(signal.SIGINT) == 130, program.said()


def expect_movie(browser, afferent, scene, folder):
    """Text has its size on a phone and on a desk: what is drawn is not scaled, and nothing is cut off."""
    movie = folder / "movie.html"
    fingertip = pathlib.Path(scene).with_name("fingertip.txtpb")
    subprocess.run([afferent, "movie", fingertip, "--out", movie], check=True, capture_output=True)
    # The page that was there looks for its program, which has ended, for as long as it is there.
    browser.get("about:blank")
    browser.get_log("browser")
    for width in (360, 1300):
        size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": True}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        browser.get(movie.as_uri())
        canvases = browser.find_elements(By.TAG_NAME, "canvas")
        assert canvases
        for canvas in canvases:
            drawn, shown = (int(canvas.get_property(each)) for each in ("width", "clientWidth"))
            assert abs(drawn - shown) <= 1, (width, drawn, shown)
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    assert not (log := browser.get_log("browser")), log
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def main():
    afferent, scene = sys.argv[1:]
    browser = chromium()
    try:
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            os.chmod(folder, 0o700)
            expect_refusals(browser, afferent, scene)
            expect_grasp(browser, afferent, scene, folder)
            expect_end(browser, afferent, scene)
            expect_restart(browser, afferent, folder)
            expect_movie(browser, afferent, scene, folder)
    finally:
        browser.quit()


if __name__ == "__main__":
    main()
