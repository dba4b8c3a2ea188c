"""A bus of 125 kbit/s as python-can attaches to it, profile `standard`: the master and slaves 2 and 3, left alone."""

import unittest
from typing import NamedTuple

import can

from spacecraft import BIT_RATE, NOMINAL, OPERATIONAL, PATIENCE, Channel, Frame

NODES = [1, 2, 3]
HEARTBEATS = {0x700 + node for node in NODES}
SYNC, SPACECRAFT_TIME = 0x080, 0x181
LOCAL_TIMES = {0x180 + node for node in NODES[1:]}
PERIOD_MS = 100
#: Of the Spacecraft Time, which is sent after each tenth SYNC.
TIME_PERIOD_MS = 1000
#: A stamp is a whole millisecond, and a frame takes up to 1.1 ms here. All others may go before it.
TOLERANCE_MS = 8


class Heard(NamedTuple):
    id: int
    data: bytes


def attach(bit_rate: int) -> can.BusABC:
    return can.Bus(interface="slcan", channel=NOMINAL, bitrate=bit_rate, sleep_after_open=0)


class SlowBus(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        """From one Spacecraft Time to another one: by time stamps, and by python-can."""
        with attach(BIT_RATE) as bus, Channel(NOMINAL) as channel:
            states = {}
            for frame in channel.frames():
                if frame.id in HEARTBEATS:
                    states[frame.id] = frame.data[0]
                if states.keys() == HEARTBEATS and set(states.values()) == {OPERATIONAL}:
                    break
            cls.stamped = cls.between_times(channel.listen(2.5))
            cls.heard = cls.by_python_can(bus)

    @staticmethod
    def between_times(frames: list[Frame]) -> list[Frame]:
        times = [nth for nth, frame in enumerate(frames) if frame.id == SPACECRAFT_TIME]
        return frames[times[0] : times[-1] + 1]

    @classmethod
    def by_python_can(cls, bus: can.BusABC) -> list[Heard]:
        """From the first to the last of the stamped frames: no two Spacecraft Times are alike."""
        first, last = (Heard(frame.id, frame.data) for frame in (cls.stamped[0], cls.stamped[-1]))
        heard: list[Heard] = []
        while not heard or heard[-1] != last:
            message = bus.recv(PATIENCE)
            assert message is not None, "python-can hears nothing more"
            frame = Heard(message.arbitration_id, bytes(message.data))
            if heard or frame == first:
                heard.append(frame)
        return heard

    def assert_periodic(self, cob_id: int, period_ms: int) -> None:
        instants = [frame.ms for frame in self.stamped if frame.id == cob_id]
        self.assertGreaterEqual(len(instants), 2, f"{cob_id:03X}h")
        for earlier, later in zip(instants, instants[1:]):
            self.assertAlmostEqual(later - earlier, period_ms, delta=TOLERANCE_MS, msg=f"{cob_id:03X}h")

    def test_python_can_sees_every_frame(self) -> None:
        self.assertEqual(self.heard, [Heard(frame.id, frame.data) for frame in self.stamped])

    def test_heartbeats_of_each_node_sync_and_time_keep_their_periods(self) -> None:
        for cob_id in [*HEARTBEATS, SYNC, *LOCAL_TIMES]:
            self.assert_periodic(cob_id, PERIOD_MS)
        self.assert_periodic(SPACECRAFT_TIME, TIME_PERIOD_MS)

    def test_a_client_with_another_bit_rate_hears_nothing(self) -> None:
        with attach(1_000_000) as bus, Channel(NOMINAL) as channel:
            self.assertTrue(channel.listen(0.5))
            self.assertIsNone(bus.recv(0.1))


if __name__ == "__main__":
    unittest.main(verbosity=2)
