"""Spacecraft Time PDO and Local Time PDO by the canopen package, which knows their bits from the slave's data sheet
(ECSS Figure 7-1): the master tells the time of each tenth SYNC, a slave its own at each.
"""

import unittest

from spacecraft import NOMINAL, Channel, Test

SYNC, SPACECRAFT_TIME, LOCAL_TIME = 0x080, 0x181, 0x183
#: Units of fine time in a second.
UNITS = 1 << 24


class Times(Test):
    def test_both_pdos_are_fine_time_then_coarse_time(self) -> None:
        (node,) = self.nodes(self.connect(), 3)
        node.remote.tpdo.read(from_od=True)
        node.remote.rpdo.read(from_od=True)
        local, spacecraft = node.remote.tpdo[1], node.remote.rpdo[1]
        self.assertEqual((local.cob_id, spacecraft.cob_id), (LOCAL_TIME, SPACECRAFT_TIME))
        self.assertEqual((local.trans_type, spacecraft.trans_type), (1, 1))
        for pdo, name in ((local, "Local SCET get"), (spacecraft, "Local SCET set")):
            self.assertEqual([variable.name for variable in pdo], [f"{name}.Fine time", f"{name}.Coarse time"])
            self.assertEqual([variable.length for variable in pdo], [24, 32])
        with Channel(NOMINAL) as channel:
            frames = [frame for frame in channel.listen(6.0) if frame.id in (SYNC, SPACECRAFT_TIME, LOCAL_TIME)]
        # The first one sets the clocks: from the SYNC after it on.
        first = next(nth for nth, frame in enumerate(frames) if frame.id == SPACECRAFT_TIME)
        frames = frames[next(nth for nth, frame in enumerate(frames) if nth > first and frame.id == SYNC) :]
        times: dict[int, list[float]] = {SPACECRAFT_TIME: [], LOCAL_TIME: []}
        of_sync: dict[int, float] = {}
        pairs = []
        for frame in frames:
            if frame.id == SYNC:
                of_sync = {}
                continue
            pdo = local if frame.id == LOCAL_TIME else spacecraft
            self.assertEqual(len(frame.data), 7)
            pdo.data[:] = frame.data
            of_sync[frame.id] = pdo[1].raw + pdo[0].raw / UNITS
            times[frame.id].append(of_sync[frame.id])
            if len(of_sync) == 2:
                pairs.append((of_sync[SPACECRAFT_TIME], of_sync[LOCAL_TIME]))
        for cob_id, period in ((SPACECRAFT_TIME, 1.0), (LOCAL_TIME, 0.1)):
            self.assertGreater(len(times[cob_id]), 2)
            for before, after in zip(times[cob_id], times[cob_id][1:]):
                self.assertAlmostEqual(after - before, period, delta=0.001)
        # Of one SYNC, by the master and by a slave: as good as their clocks are, seconds after the start.
        self.assertGreater(len(pairs), 1)
        for by_master, by_slave in pairs:
            self.assertAlmostEqual(by_master, by_slave, delta=20e-6)


if __name__ == "__main__":
    unittest.main(verbosity=2)
