"""The DCF of slave 3, a test device, loaded into it by the canopen package; master is this script."""

import unittest

import canopen
from canopen.objectdictionary import ODVariable

from spacecraft import DCF, PRE_OPERATIONAL, Test


class Configuration(Test):
    def setUp(self) -> None:
        self.net = self.connect(is_master=True)
        (self.slave,) = self.nodes(self.net, 3)
        self.slave.remote.nmt.state = "PRE-OPERATIONAL"
        self.slave.becomes(PRE_OPERATIONAL)

    def test_the_slave_takes_its_configuration(self) -> None:
        """PDOs as the package writes them, and values that were changed before it."""
        changed = {(0x1017, 0): 333, (0x6210, 0): 0xCAFE, (0x6400, 0x1C): -7}
        dictionary = canopen.import_od(str(DCF))
        remote = canopen.RemoteNode(3, dictionary)
        self.net.add_node(remote)
        for (index, sub), value in changed.items():
            entry = dictionary[index]
            (entry if isinstance(entry, ODVariable) else entry[sub]).value = value
        remote.load_configuration()
        for (index, sub), value in changed.items():
            self.assertEqual(int.from_bytes(remote.sdo.upload(index, sub), "little", signed=value < 0), value)
        for first in (0x1400, 0x1800):
            for number in range(8):
                described = dictionary[first + number][1].default
                # Bit 30 is the device's own: it allows no RTR.
                self.assertEqual(remote.sdo[first + number][1].raw | 1 << 30, described | 1 << 30)

    def test_reset_brings_the_defaults_back(self) -> None:
        sdo = self.slave.remote.sdo
        sdo[0x1017].raw = 444
        self.slave.states.forget()
        self.slave.remote.nmt.state = "RESET COMMUNICATION"
        self.slave.boots()
        self.assertEqual(sdo[0x1017].raw, 250)


if __name__ == "__main__":
    unittest.main(verbosity=2)
