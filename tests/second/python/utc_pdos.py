"""PDOs with the UTC of slave 3, a test device, by the canopen package, which knows their bits from the device's data sheet (ECSS
Figure 7-2); master, producer of SYNC and of the time is this script.
"""

import struct
import unittest

from spacecraft import OPERATIONAL, PRE_OPERATIONAL, Test, Observer

UTC_SET, UTC_GET = 0x2012, 0x2013
DAY, MS, SUBMILLISECONDS = 1, 2, 3
SPARE, SPACECRAFT_TIME, LOCAL_TIME = 5, 0x1C1, 0x1C2
MS_OF_DAY = 86_400_000


class Utc(Test):
    def test_both_pdos_are_submilliseconds_then_milliseconds_then_day(self) -> None:
        net = self.connect(is_master=True)
        (slave,) = self.nodes(net, 3)
        remote = slave.remote
        remote.nmt.state = "PRE-OPERATIONAL"
        slave.becomes(PRE_OPERATIONAL)
        remote.rpdo.read()
        remote.tpdo.read()
        spacecraft, local = remote.rpdo[SPARE], remote.tpdo[SPARE]
        for pdo, index, cob_id, kind in ((spacecraft, UTC_SET, SPACECRAFT_TIME, 255), (local, UTC_GET, LOCAL_TIME, 1)):
            pdo.clear()
            for sub in (SUBMILLISECONDS, MS, DAY):
                pdo.add_variable(index, sub)
            pdo.cob_id, pdo.trans_type, pdo.enabled = cob_id, kind, True
            pdo.save()
            self.assertEqual([variable.length for variable in pdo], [16, 32, 16])
        told = Observer()
        local.add_callback(lambda pdo: told((bytes(pdo.data), [variable.raw for variable in pdo])))
        remote.nmt.state = "OPERATIONAL"
        slave.becomes(OPERATIONAL)
        micros, ms, day = 456, 43_200_123, 20_780
        spacecraft[0].raw, spacecraft[1].raw, spacecraft[2].raw = micros, ms, day
        self.assertEqual(bytes(spacecraft.data), struct.pack("<HIH", micros, ms, day))
        spacecraft.transmit()
        self.assert_soon_after(net, told, day, ms, micros)
        # The last microsecond of a day, by command: the day after it comes by itself.
        for sub, value in ((DAY, day), (MS, MS_OF_DAY - 1), (SUBMILLISECONDS, 999)):
            remote.sdo[UTC_SET][sub].raw = value
        told.forget()
        self.assertEqual(self.assert_soon_after(net, told, day, MS_OF_DAY - 1, 999), day + 1)

    def assert_soon_after(self, net, told: Observer, day: int, ms: int, micros: int) -> int:
        """The time of the slave at a SYNC is this one, but for some seconds. Returns its day."""
        net.sync.transmit()
        octets, values = told.wait_for(bool)[0]
        self.assertEqual(list(struct.unpack("<HIH", octets)), values)
        micros_later, ms_later, day_later = values
        self.assertLess(micros_later, 1_000)
        later = ((day_later - day) * MS_OF_DAY + ms_later - ms) * 1_000 + micros_later - micros
        # One frame on the wire at least.
        self.assertGreater(later, 50)
        self.assertLess(later, 10_000_000)
        return day_later


if __name__ == "__main__":
    unittest.main(verbosity=2)
