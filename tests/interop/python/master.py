"""The emulated master and slaves 2 and 3, with a foreign client that interferes."""

import unittest

from spacecraft import OPERATIONAL, STOPPED, Test, Witness


class Master(Test):
    def setUp(self) -> None:
        self.net = self.connect()
        (self.node,) = self.nodes(self.net, 2)
        self.commands = Witness()
        self.net.subscribe(0x000, lambda _id, data, _at: self.commands(bytes(data)))
        self.node.becomes(OPERATIONAL)

    def starts(self, told: list) -> bool:
        return b"\x01\x02" in told or b"\x01\x00" in told

    def test_a_slave_that_is_set_back_is_started_again(self) -> None:
        self.node.remote.nmt.state = "PRE-OPERATIONAL"
        self.commands.wait_for(self.starts)
        self.node.becomes(OPERATIONAL, times=2)

    def test_a_slave_that_is_reset_is_started_again(self) -> None:
        self.node.states.forget()
        self.node.remote.nmt.state = "RESET"
        self.node.boots()
        self.commands.wait_for(self.starts)
        self.node.becomes(OPERATIONAL, times=2)

    def test_a_slave_that_is_stopped_stays_so(self) -> None:
        self.node.remote.nmt.state = "STOPPED"
        self.node.becomes(STOPPED, times=5)
        self.node.remote.nmt.state = "OPERATIONAL"
        self.node.becomes(OPERATIONAL)


if __name__ == "__main__":
    unittest.main(verbosity=2)
