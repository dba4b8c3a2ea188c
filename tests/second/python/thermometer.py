"""The example thermometer by its own data sheet: objects, PDOs, limits, its table; its master flies, too."""

import struct
import unittest

from canopen.sdo import SdoAbortedError

from spacecraft import NOMINAL, PATIENCE, Channel, Test

#: COB-IDs of its PDO with every SYNC, and of requests to its SDO server.
CYCLE, REQUEST = 0x483, 0x603

#: The table that its master writes: a tenth of a degree more every 64 entries.
TABLE = struct.pack("<1024h", *(entry // 64 for entry in range(1024)))
#: Abort code of a value that does not go with another one (CiA 301 table 22).
INCOMPATIBLE = 0x06040043


class Thermometer(Test):
    @classmethod
    def setUpClass(cls) -> None:
        """Its master calibrates it first; an SDO server has one client at a time."""
        with Channel(NOMINAL) as channel:
            heard: set[int] = set()
            while CYCLE not in heard or REQUEST in heard:
                heard = {frame.id for frame in channel.listen(1.0)}

    def setUp(self) -> None:
        (self.node,) = self.nodes(self.connect(), 3)
        self.sdo = self.node.remote.sdo

    def test_the_temperature_is_that_of_the_sensor(self) -> None:
        """The sensor has 25 degrees; the table adds nine tenths."""
        self.until(lambda: self.sdo["Temperature"].raw == 259)
        self.assertEqual(self.sdo["Manufacturer device name"].raw, "Thermometer")

    def test_limits_are_checked_against_each_other(self) -> None:
        for name, value in (("Upper limit", -200), ("Lower limit", 850)):
            with self.assertRaises(SdoAbortedError, msg=name) as refusal:
                self.sdo[name].raw = value
            self.assertEqual(refusal.exception.code, INCOMPATIBLE)

    def test_a_limit_that_is_exceeded_sends_a_pdo(self) -> None:
        tpdo = self.node.remote.tpdo
        tpdo.read()
        self.assertEqual([variable.name for variable in tpdo[2]], ["Temperature", "Alarm"])
        self.assertEqual([variable.name for variable in tpdo[4]], ["Temperature", "Highest temperature"])
        self.addCleanup(setattr, self.sdo["Upper limit"], "raw", 850)
        self.sdo["Upper limit"].raw = 240
        self.assertIsNotNone(tpdo[2].wait_for_reception(PATIENCE))
        self.assertEqual((tpdo[2]["Temperature"].raw, tpdo[2]["Alarm"].raw), (259, 1))

    def test_a_command_comes_by_pdo(self) -> None:
        rpdo = self.node.remote.rpdo
        rpdo.read()
        rpdo[1]["Command"].raw = 1
        rpdo[1].transmit()
        self.until(lambda: self.sdo["Command"].raw == 1)
        self.assertEqual(self.sdo["Highest temperature"].raw, self.sdo["Temperature"].raw)

    def test_the_table_is_read_in_blocks(self) -> None:
        with self.sdo["Calibration table"].open("rb", size=len(TABLE), block_transfer=True) as table:
            self.assertEqual(table.read(), TABLE)


if __name__ == "__main__":
    unittest.main(verbosity=2)
