"""A spacecraft left alone, profile `standard`: the master and slaves 2 to 4. Nobody sends anything here."""

import unittest

from spacecraft import NOMINAL, OPERATIONAL, REDUNDANT, Channel, Node, Observer, network

NODES = [1, 2, 3, 4]
PERIOD_MS = 100
#: Stamps are whole milliseconds, and a frame may wait for another one.
TOLERANCE_MS = 3


class Listening(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        """Two seconds of a spacecraft that has come up, by virtual time."""
        with Channel(REDUNDANT) as other, Channel(NOMINAL) as channel:
            states = {}
            for frame in channel.frames():
                if frame.id >> 7 == 0x700 >> 7:
                    states[frame.id & 0x7F] = frame.data[0]
                if sorted(states) == NODES and set(states.values()) == {OPERATIONAL}:
                    break
            cls.frames = channel.listen(2)
            cls.other_is_silent = other.is_silent()

    def instants(self, cob_id: int) -> list[int]:
        return [frame.ms for frame in self.frames if frame.id == cob_id]

    def assert_periodic(self, cob_id: int) -> None:
        instants = self.instants(cob_id)
        self.assertIn(len(instants), range(19, 22), f"{cob_id:03X}h")
        for earlier, later in zip(instants, instants[1:]):
            self.assertAlmostEqual(later - earlier, PERIOD_MS, delta=TOLERANCE_MS, msg=f"{cob_id:03X}h")

    def test_everybody_sends_heartbeats_with_the_period_of_the_profile(self) -> None:
        for node in NODES:
            self.assert_periodic(0x700 + node)

    def test_everybody_is_operational(self) -> None:
        states = {bytes(frame.data) for frame in self.frames if frame.id in range(0x700, 0x780)}
        self.assertEqual(states, {bytes([OPERATIONAL])})

    def test_sync_is_periodic(self) -> None:
        self.assert_periodic(0x080)

    def test_the_redundant_bus_is_silent(self) -> None:
        self.assertTrue(self.other_is_silent)


class CanopenPackage(unittest.TestCase):
    def test_it_finds_all_nodes_and_their_states(self) -> None:
        with network() as net:
            for node in [Node(net, number) for number in NODES]:
                node.becomes(OPERATIONAL, times=2)
            self.assertEqual(sorted(net.scanner.nodes), NODES)

    def test_subscribers_see_sync(self) -> None:
        seen = Observer()
        with network() as net:
            net.subscribe(0x080, lambda _id, data, _at: seen(bytes(data)))
            self.assertEqual(set(seen.wait_for(lambda told: len(told) >= 5)), {b""})


if __name__ == "__main__":
    unittest.main(verbosity=2)
