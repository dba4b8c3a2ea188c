"""EDS and DCF of a slave, which SLAVE_EDS names, and of the master as the canopen package understands them."""

import logging
import os
import tempfile
import unittest
from configparser import RawConfigParser
from pathlib import Path

import canopen
from canopen.objectdictionary import ODVariable, ObjectDictionary, datatypes

EDS = Path(os.environ["SLAVE_EDS"])
DCF = EDS.with_name(f"{EDS.stem}-3.dcf")
MASTER_EDS = Path(__file__).parents[3] / "docs/eds/master.eds"
NODE = 3
#: Have no default: readers disagree on how it is written.
UNWRITTEN = (datatypes.DOMAIN, datatypes.TIME_OF_DAY, datatypes.TIME_DIFFERENCE)
#: Have none where they are zero or empty: some readers do not know these types.
RARE = (
    datatypes.INTEGER24, datatypes.INTEGER40, datatypes.INTEGER48, datatypes.INTEGER56, datatypes.UNSIGNED24,
    datatypes.UNSIGNED40, datatypes.UNSIGNED48, datatypes.UNSIGNED56, datatypes.UNICODE_STRING,
)


def variables(dictionary: ObjectDictionary) -> dict[tuple[int, int], ODVariable]:
    """Every value by index and sub-index, without the types that stand for dummy entries."""
    found = {}
    for entry in dictionary.values():
        subs = [entry] if isinstance(entry, ODVariable) else list(entry.values())
        found.update({(sub.index, sub.subindex): sub for sub in subs if sub.index >= 0x1000})
    return found


class DataSheets(unittest.TestCase):
    def setUp(self) -> None:
        with self.assertNoLogs("canopen", logging.WARNING):
            self.eds = canopen.import_od(str(EDS), NODE)
            self.dcf = canopen.import_od(str(DCF))

    def test_the_device_is_known(self) -> None:
        device = self.eds.device_information
        self.assertTrue(device.simple_boot_up_slave)
        self.assertFalse(device.simple_boot_up_master)
        self.assertFalse(device.LSS_supported)
        self.assertEqual(device.nr_of_RXPDO, 8)
        self.assertEqual(device.nr_of_TXPDO, 8)
        self.assertEqual(device.allowed_baudrates, {k * 1000 for k in (10, 20, 50, 125, 250, 500, 1000)})

    def test_the_master_is_described_as_well(self) -> None:
        with self.assertNoLogs("canopen", logging.WARNING):
            eds = canopen.import_od(str(MASTER_EDS), 1)
            dcf = canopen.import_od(str(MASTER_EDS.with_suffix(".dcf")))
        self.assertTrue(eds.device_information.simple_boot_up_master)
        self.assertEqual(dcf.node_id, 1)
        self.assertEqual(variables(eds).keys(), variables(dcf).keys())
        self.assertEqual(dcf[0x1200][1].default, 0x601)
        self.assertEqual(len(dcf[0x1F81]), 128, "the assignment of each slave, and their number")

    def test_the_node_is_commissioned(self) -> None:
        self.assertEqual(self.dcf.node_id, NODE)
        self.assertEqual(self.dcf.bitrate, 1_000_000)

    def test_every_section_became_an_object(self) -> None:
        raw = RawConfigParser(strict=True)
        raw.read_string(EDS.read_text("ascii"))
        lists = ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects")
        listed = [int(index, 16) for name in lists for key, index in raw.items(name) if key.isdigit()]
        self.assertEqual(len(set(listed)), len(listed))
        self.assertEqual(sum(raw.getint(name, "SupportedObjects") for name in lists), len(listed))
        self.assertEqual({entry.index for entry in self.eds.values() if entry.index >= 0x1000}, set(listed))
        self.assertEqual([0x1000, 0x1001, 0x1018], listed[:3])

    def test_identifiers_are_those_of_the_node(self) -> None:
        rpdos = (0x181, 0x300 + NODE, 0x400 + NODE, 0x500 + NODE)
        tpdos = (0x180 + NODE, 0x280 + NODE, 0x380 + NODE, 0x480 + NODE)
        for dictionary in (self.eds, self.dcf):
            self.assertEqual(dictionary[0x1005].default & 0x7FF, 0x080)
            self.assertEqual(dictionary[0x1014].default, 0x080 + NODE)
            for number, (rpdo, tpdo) in enumerate(zip(rpdos, tpdos)):
                self.assertEqual(dictionary[0x1400 + number][1].default & 0x7FF, rpdo)
                self.assertEqual(dictionary[0x1800 + number][1].default & 0x7FF, tpdo)
            self.assertEqual(dictionary[0x1200][1].default, 0x600 + NODE)
            self.assertEqual(dictionary[0x1200][2].default, 0x580 + NODE)

    def test_objects_are_found_by_their_names(self) -> None:
        self.assertEqual(self.eds["Producer heartbeat time"].index, 0x1017)
        self.assertEqual(self.eds["Identity object"]["Serial number"].subindex, 4)
        self.assertEqual(self.eds["Redundancy"]["Ttoggle"].subindex, 2)
        names = [entry.name for entry in self.eds.values()]
        self.assertEqual(len(set(names)), len(names))

    def test_values_are_understood_and_keep_their_limits(self) -> None:
        for at, value in variables(self.eds).items():
            with self.subTest(index=f"{at[0]:04X}h", sub=at[1], name=value.name):
                self.assertIn(value.access_type, ("ro", "wo", "rw", "rwr", "rww", "const"))
                # 1003h: an error that has not occurred cannot be read (08000024h).
                is_error = at[0] == 0x1003 and at[1] > 0
                if not value.readable or value.data_type in UNWRITTEN or is_error:
                    self.assertIsNone(value.default)
                    continue
                if value.data_type in RARE and value.default is None:
                    continue
                self.assertIsNotNone(value.default)
                if value.data_type in datatypes.INTEGER_TYPES:
                    self.assertEqual(value.decode_raw(value.encode_raw(value.default)), value.default)
                    self.assertLessEqual(value.default if value.min is None else value.min, value.default)
                    self.assertGreaterEqual(value.default if value.max is None else value.max, value.default)

    def test_the_configuration_has_all_of_the_data_sheet(self) -> None:
        described, configured = variables(self.eds), variables(self.dcf)
        self.assertEqual(described.keys(), configured.keys())
        for at, value in described.items():
            for attribute in ("name", "data_type", "access_type", "pdo_mappable", "default", "min", "max"):
                self.assertEqual(getattr(value, attribute), getattr(configured[at], attribute), (at, attribute))

    def test_nothing_is_lost_when_the_package_writes_it_again(self) -> None:
        with tempfile.TemporaryDirectory() as directory:
            path = os.path.join(directory, "again.dcf")
            canopen.export_od(self.dcf, path)
            again = variables(canopen.import_od(path))
        for at, value in variables(self.dcf).items():
            for attribute in ("name", "data_type", "access_type", "pdo_mappable", "default", "value"):
                self.assertEqual(getattr(value, attribute), getattr(again[at], attribute), (at, attribute))


if __name__ == "__main__":
    unittest.main(verbosity=2)
