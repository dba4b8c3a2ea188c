"""The emulated master and slaves 2 and 3, with a foreign client that interferes."""

import unittest

from spacecraft import MASTER_EDS, OPERATIONAL, STOPPED, Test, Observer


class Master(Test):
    def setUp(self) -> None:
        self.net = self.connect()
        (self.node,) = self.nodes(self.net, 2)
        self.commands = Observer()
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

    def test_a_slave_that_a_foreign_node_stops_is_started_again(self) -> None:
        self.node.states.forget()
        self.node.remote.nmt.state = "STOPPED"
        self.node.states.wait_for(lambda told: STOPPED in told)
        self.commands.wait_for(self.starts)
        self.node.becomes(OPERATIONAL, times=2)

    def test_a_slave_that_the_master_is_to_stop_stays_so(self) -> None:
        """1F82h of the master: a module control command, by a client."""
        master = self.net.add_node(1, str(MASTER_EDS))
        master.sdo.download(0x1F82, 2, bytes([STOPPED]))
        self.node.becomes(STOPPED, times=5)
        master.sdo.download(0x1F82, 2, bytes([OPERATIONAL]))
        self.node.becomes(OPERATIONAL)


if __name__ == "__main__":
    unittest.main(verbosity=2)
