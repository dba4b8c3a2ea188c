"""What the scripts share: networks of the canopen package, and channels by SLCAN with the twin's own time.

Virtual time follows the clock on the wall only as well as the computer can: periods are taken from the time stamps of
SLCAN, and whatever is waited for may take long.
"""

import contextlib
import faulthandler
import os
import pathlib
import socket
import struct
import threading
import time
import unittest
import urllib.parse
from typing import Callable, Iterator, NamedTuple

import canopen

# A script that hangs ends, and says where.
faulthandler.dump_traceback_later(300, exit=True)

#: Addresses of the buses.
NOMINAL = os.environ.get("SLCAN_NOMINAL", "socket://127.0.0.1:29501")
REDUNDANT = os.environ.get("SLCAN_REDUNDANT", "socket://127.0.0.1:29502")
#: Bit rate of the buses, bit/s.
BIT_RATE = int(os.environ.get("BIT_RATE", 1_000_000))

DOCS = pathlib.Path(__file__).parents[3] / "docs/eds"
#: The data sheets of the slaves, test devices where some fly, of number 3, and of the master.
EDS = pathlib.Path(os.environ.get("SLAVE_EDS", DOCS / "slave.eds"))
DCF = EDS.with_name(f"{EDS.stem}-3.dcf")
MASTER_EDS = DOCS / "master.eds"

#: What has not happened after so many seconds does not happen.
PATIENCE = 60.0

#: States in heartbeats (CiA 301 7.2.8.3.2.2).
BOOT_UP, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0x00, 0x04, 0x05, 0x7F


class Frame(NamedTuple):
    """A data frame and when it was on the bus, in milliseconds of virtual time."""

    ms: int
    id: int
    data: bytes


class Channel:
    """A channel of one bus, SLCAN by hand: python-can does not ask for time stamps."""

    #: Stamps begin anew after so many milliseconds.
    MINUTE = 60_000

    def __init__(self, url: str) -> None:
        address = urllib.parse.urlsplit(url)
        self._socket = socket.create_connection((address.hostname, address.port), PATIENCE)
        self._buffer = b""
        self._ms: int | None = None
        for command in (b"Z1", b"O"):
            self._socket.sendall(command + b"\r")
            while not self._buffer:
                self._receive()
            answer, self._buffer = self._buffer[:1], self._buffer[1:]
            assert answer == b"\r", f"{command!r} is refused: {answer!r}"

    def __enter__(self) -> "Channel":
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def frames(self) -> Iterator[Frame]:
        """Data frames with 11-bit identifiers as they come; for ever."""
        while True:
            *lines, self._buffer = self._buffer.split(b"\r")
            for line in lines:
                assert b"\a" not in line, f"refused: {line!r}"
                if line.startswith(b"t"):
                    yield self._frame(line.decode())
            self._receive()

    def _receive(self) -> None:
        received = self._socket.recv(65536)
        assert received, "the spacecraft has hung up"
        self._buffer += received

    def _frame(self, line: str) -> Frame:
        end = 5 + 2 * int(line[4])
        stamp = int(line[end:], 16)
        if self._ms is None:
            self._ms = stamp
        # The stamp is that of the minute; frames come in order.
        self._ms += (stamp - self._ms) % self.MINUTE
        return Frame(self._ms, int(line[1:4], 16), bytes.fromhex(line[5:end]))

    def listen(self, seconds: float) -> list[Frame]:
        """All frames of so many seconds of virtual time; somebody must be heard."""
        heard: list[Frame] = []
        for frame in self.frames():
            heard.append(frame)
            if frame.ms - heard[0].ms >= 1000 * seconds:
                return heard
        raise AssertionError("frames() does not end")

    def is_silent(self) -> bool:
        """Nothing has come that was not taken."""
        self._socket.setblocking(False)
        try:
            self._receive()
        except BlockingIOError:
            pass
        finally:
            self._socket.settimeout(PATIENCE)
        return not self._buffer


class Observer:
    """Keeps what is told to it from another thread, and waits for what is wanted."""

    def __init__(self) -> None:
        self._told: list = []
        self._changed = threading.Condition()

    def __call__(self, what: object) -> None:
        with self._changed:
            self._told.append(what)
            self._changed.notify_all()

    def forget(self) -> None:
        """From now on."""
        with self._changed:
            self._told.clear()

    def wait_for(self, wanted: Callable[[list], bool]) -> list:
        """All that was told, as soon as `wanted` is content with it."""
        with self._changed:
            if not self._changed.wait_for(lambda: wanted(self._told), PATIENCE):
                raise AssertionError(f"not told in time; the last: {self._told[-20:]}")
            return list(self._told)


@contextlib.contextmanager
def network(url: str = NOMINAL, is_master: bool = False) -> Iterator[canopen.Network]:
    """A network of the canopen package; as the master it lets its heartbeat be heard as that of node 1."""
    found = canopen.Network()
    found.connect(interface="slcan", channel=url, bitrate=BIT_RATE, sleep_after_open=0)
    try:
        if is_master:
            found.send_periodic(0x701, bytes([OPERATIONAL]), 0.25)
        yield found
    finally:
        found.disconnect()


class Test(unittest.TestCase):
    """A test with a network of its own."""

    def connect(self, url: str = NOMINAL, is_master: bool = False) -> canopen.Network:
        """A network until the end of the test."""
        stack = contextlib.ExitStack()
        self.addCleanup(stack.close)
        return stack.enter_context(network(url, is_master))

    def until(self, wanted: Callable[[], bool]) -> None:
        """Asks again and again, until the answer is yes."""
        end = time.monotonic() + PATIENCE
        while not wanted():
            self.assertLess(time.monotonic(), end, "it does not happen")

    def nodes(self, net: canopen.Network, *numbers: int) -> list["Node"]:
        """These nodes, all of which have been heard: until then they may have no power."""
        nodes = [Node(net, number) for number in numbers]
        for node in nodes:
            node.states.wait_for(bool)
        return nodes


class Node:
    """A node of a network, its heartbeats and its telemetry."""

    def __init__(self, net: canopen.Network, number: int) -> None:
        self.number = number
        self._network = net
        self._sequence = 0
        self.remote = net.add_node(number, str(EDS))
        self.remote.sdo.RESPONSE_TIMEOUT = PATIENCE
        self.states = Observer()
        self.remote.nmt.add_heartbeat_callback(self.states)
        self.telemetry = Observer()
        net.subscribe(0x380 + number, lambda _id, data, _at: self.telemetry(bytes(data)))

    def becomes(self, state: int, times: int = 1) -> None:
        """Waits until the last so many heartbeats from now on say so."""
        self.states.forget()
        self.states.wait_for(lambda told: len(told) >= times and set(told[-times:]) == {state})

    def boots(self) -> None:
        """Waits for a boot-up message since the states were forgotten."""
        self.states.wait_for(lambda told: BOOT_UP in told)

    def command(self, code: int, data: bytes = b"") -> None:
        """A telecommand: code, 5 bytes, and a sequence that is stepped with each."""
        self._network.send_message(0x300 + self.number, struct.pack("<H5sB", code, data, self._sequence))
        self._sequence = (self._sequence + 1) % 256

    def repeat(self, code: int, data: bytes = b"") -> None:
        """The last telecommand again, with its sequence."""
        sequence = (self._sequence - 1) % 256
        self._network.send_message(0x300 + self.number, struct.pack("<H5sB", code, data, sequence))

    def ask(self, code: int, zeros: int = 6) -> bytes:
        """Telemetry, without its code: 6 bytes. The request has so many zeros behind its code."""
        request = struct.pack("<H", code)
        self.telemetry.forget()
        self._network.send_message(0x400 + self.number, request + bytes(zeros))
        told = self.telemetry.wait_for(lambda told: any(answer.startswith(request) for answer in told))
        return next(answer[2:] for answer in told if answer.startswith(request))
