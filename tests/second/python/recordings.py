"""What `cargo demo` has recorded, read by can-utils, tshark and python-can: they must find the same frames."""

import collections
import os
import pathlib
import subprocess
import tempfile
import unittest
from typing import NamedTuple

import can

DIRECTORY = pathlib.Path(os.environ["RECORDINGS"])
BUSES = ["nominal", "redundant"]


class Frame(NamedTuple):
    seconds: float
    id: int
    data: bytes


def by_python_can(path: pathlib.Path) -> list[Frame]:
    return [Frame(message.timestamp, message.arbitration_id, bytes(message.data)) for message in can.LogReader(path)]


def by_tshark(*arguments: str) -> list[list[str]]:
    """Rows of fields."""
    command = ["tshark", "-n", "-r", DIRECTORY / "spacecraft.pcapng", "-T", "fields", *arguments]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return [line.split("\t") for line in output.splitlines()]


class Recordings(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.logs = {bus: by_python_can(DIRECTORY / f"bus-{bus}.log") for bus in BUSES}
        for bus, frames in cls.logs.items():
            assert len(frames) > 100, f"{bus}: {len(frames)} frames in 3 s"

    def assert_same(self, found: list[Frame], expected: list[Frame]) -> None:
        self.assertEqual([frame[1:] for frame in found], [frame[1:] for frame in expected])
        for one, other in zip(found, expected):
            self.assertAlmostEqual(one.seconds, other.seconds, delta=2e-6)

    def test_log2asc_translates_every_frame(self) -> None:
        for bus, frames in self.logs.items():
            with tempfile.TemporaryDirectory() as here:
                asc = pathlib.Path(here) / f"{bus}.asc"
                log = DIRECTORY / f"bus-{bus}.log"
                subprocess.run(["log2asc", "-I", log, "-O", asc, bus], check=True)
                translated = by_python_can(asc)
            self.assertEqual([frame[1:] for frame in translated], [frame[1:] for frame in frames])
            # log2asc takes second 0 for "no frame yet": its time begins with the first frame after that.
            began = min(frame.seconds for frame in frames if frame.seconds >= 1)
            for one, other in zip(translated, frames):
                self.assertAlmostEqual(one.seconds, max(other.seconds - began, 0), delta=2e-6)

    def test_tshark_finds_every_frame_on_its_bus(self) -> None:
        fields = ["frame.interface_name", "frame.time_epoch", "can.id", "data.data"]
        rows = by_tshark("-d", "can.subdissector,data", *(f"-e{field}" for field in fields))
        found = collections.defaultdict(list)
        for bus, seconds, number, data in rows:
            found[bus].append(Frame(float(seconds), int(number, 0), bytes.fromhex(data.replace(":", ""))))
        self.assertEqual(sorted(found), BUSES)
        for bus, frames in self.logs.items():
            self.assert_same(found[bus], frames)

    def test_tshark_understands_the_services(self) -> None:
        dissect = ["-d", "can.subdissector,canopen"]
        frames = [frame for frames in self.logs.values() for frame in frames]
        for what, fields, identifiers in [
            ("canopen.nmt_guard.state", ["can.id", "canopen.nmt_guard.state"], range(0x701, 0x780)),
            ("canopen.nmt_ctrl.cd", ["can.id", "canopen.nmt_ctrl.cd", "canopen.nmt_ctrl.node_id"], range(1)),
        ]:
            rows = by_tshark(*dissect, "-Y", what, *(f"-e{field}" for field in fields))
            found = sorted(tuple(int(value, 0) for value in row) for row in rows)
            expected = sorted((frame.id, *frame.data) for frame in frames if frame.id in identifiers)
            self.assertGreaterEqual(len(expected), 2)
            self.assertEqual(found, expected, what)


if __name__ == "__main__":
    unittest.main(verbosity=2)
