//! The sections of both files (CiA 306 4.4 to 4.7, 5).

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use ecss_can::od::{Access, DataType, ObjectCode, Objects};
use ecss_can::types::NodeId;

use crate::device::{BIT_RATES, Commissioning, Device};
use crate::dictionary::{Described, Dictionary, Value, describe, has_text, read};
use crate::file::File;
use crate::{Error, notes, value};

/// Objects that every device has (CiA 301 7.5.1).
const MANDATORY: [u16; 3] = [0x1000, 0x1001, IDENTITY];
const IDENTITY: u16 = 0x1018;
const MANUFACTURER: RangeInclusive<u16> = 0x2000..=0x5FFF;
const RPDOS: RangeInclusive<u16> = 0x1400..=0x15FF;
const TPDOS: RangeInclusive<u16> = 0x1800..=0x19FF;

/// What a DCF has beside the defaults, by index and sub-index.
type Parameters = BTreeMap<(u16, u8), String>;

/// A type of device and its object dictionary.
#[derive(Clone, Debug)]
pub struct Description {
    device: Device,
    dictionary: Dictionary,
    /// Defaults as text, by index and sub-index.
    defaults: Parameters,
    /// Vendor-ID, product code, revision number; zero where there is no 1018h.
    identity: [u64; 3],
}

impl Description {
    /// Describes the dictionary that `make` gives a node after power-on; it makes one for each Node-ID of the device.
    ///
    /// # Errors
    /// [`Error`], whatever it is.
    pub fn new<D: Objects>(device: &Device, make: impl Fn(NodeId) -> D) -> Result<Description, Error> {
        device.check()?;
        let mut nodes: Vec<(NodeId, D)> = device.nodes().map(|node| (node, make(node))).collect();
        let dictionary = describe(&mut nodes)?;
        let mut defaults = Parameters::new();
        for (at, value) in values(&dictionary) {
            if let Some(text) = value.default.text(value.entry.data_type)? {
                defaults.insert(at, text);
            }
        }
        let mut identity = |sub| {
            let (_, objects) = nodes.first_mut()?;
            Some(value::number(&read(objects, IDENTITY, sub).ok()?))
        };
        let identity = [1, 2, 3].map(|sub| identity(sub).unwrap_or(0));
        Ok(Description { device: device.clone(), dictionary, defaults, identity })
    }

    /// The electronic data sheet; `name` is that of the file.
    pub fn eds(&self, name: &str) -> String {
        let mut file = File::default();
        self.file_info(&mut file, name, None);
        self.device_info(&mut file);
        self.objects(&mut file, &Parameters::new());
        file.into_text()
    }

    /// The device configuration file of a node whose dictionary is `configured`; `name` is that of the file, `eds` that of
    /// the data sheet.
    ///
    /// # Errors
    /// [`Error::Text`] in a value or in `commissioning`, [`Error::Missing`] where `configured` is another dictionary.
    pub fn dcf<D: Objects>(
        &self,
        name: &str,
        eds: &str,
        commissioning: &Commissioning,
        configured: &mut D,
    ) -> Result<String, Error> {
        commissioning.check()?;
        let mut parameters = Parameters::new();
        let has_text = |((index, sub), value): &((u16, u8), &Value)| has_text(*index, *sub, value.entry);
        for ((index, sub), value) in values(&self.dictionary).filter(has_text) {
            let bytes = read(configured, index, sub)?;
            if !value.default.tells(commissioning.node, &bytes) {
                parameters.insert((index, sub), value::text(value.entry.data_type, &bytes)?);
            }
        }
        let serial = read(configured, IDENTITY, 4).map_or(0, |serial| value::number(&serial));
        let mut file = File::default();
        self.file_info(&mut file, name, Some(eds));
        self.device_info(&mut file);
        commissioned(&mut file, commissioning, serial);
        self.objects(&mut file, &parameters);
        Ok(file.into_text())
    }

    fn file_info(&self, file: &mut File, name: &str, eds: Option<&str>) {
        let device = &self.device;
        file.section("FileInfo");
        file.set("FileName", name);
        file.set("FileVersion", device.version);
        file.set("FileRevision", device.revision);
        if let Some(eds) = eds {
            file.set("LastEDS", eds);
        }
        file.set("EDSVersion", "4.0");
        file.set("Description", &device.description);
        file.set("CreationTime", device.created.time());
        file.set("CreationDate", device.created.date());
        file.set("CreatedBy", &device.author);
        file.set("ModificationTime", device.modified.time());
        file.set("ModificationDate", device.modified.date());
        file.set("ModifiedBy", &device.author);
    }

    fn device_info(&self, file: &mut File) {
        let device = &self.device;
        let [vendor, product, revision] = self.identity;
        file.section("DeviceInfo");
        file.set("VendorName", &device.vendor);
        file.set("VendorNumber", format_args!("0x{vendor:08X}"));
        file.set("ProductName", &device.product);
        file.set("ProductNumber", format_args!("0x{product:08X}"));
        file.set("RevisionNumber", format_args!("0x{revision:08X}"));
        file.set("OrderCode", &device.order_code);
        for rate in BIT_RATES {
            file.flag(format_args!("BaudRate_{rate}"), device.bit_rates.contains(&rate));
        }
        file.flag("SimpleBootUpMaster", device.boot_up_master);
        file.flag("SimpleBootUpSlave", device.boot_up_slave);
        file.set("Granularity", device.granularity);
        // Network variables (CiA 302-4), compact PDO sections, group messages (CiA 301 MPDO) and LSS (CiA 305): none.
        file.set("DynamicChannelsSupported", 0);
        file.set("CompactPDO", 0);
        file.set("GroupMessaging", 0);
        file.set("NrOfRXPDO", self.dictionary.range(RPDOS).count());
        file.set("NrOfTXPDO", self.dictionary.range(TPDOS).count());
        file.set("LSS_Supported", 0);

        file.section("DummyUsage");
        for index in 1..=7 {
            file.flag(format_args!("Dummy{index:04X}"), DataType::of_dummy(index).is_some());
        }
        let notes = notes::of(&self.dictionary);
        file.section("Comments");
        file.set("Lines", device.comments.len() + notes.len());
        for (line, comment) in (1..).zip(device.comments.iter().chain(&notes)) {
            file.set(format_args!("Line{line}"), comment);
        }
    }

    fn objects(&self, file: &mut File, parameters: &Parameters) {
        let is_mandatory = |index: &u16| MANDATORY.contains(index);
        let is_manufacturers = |index: &u16| MANUFACTURER.contains(index);
        self.list(file, parameters, "MandatoryObjects", is_mandatory);
        self.list(file, parameters, "OptionalObjects", |index| {
            !is_mandatory(index) && !is_manufacturers(index)
        });
        self.list(file, parameters, "ManufacturerObjects", is_manufacturers);
    }

    fn list(&self, file: &mut File, parameters: &Parameters, name: &str, belongs: impl Fn(&u16) -> bool) {
        let objects: Vec<_> = self.dictionary.iter().filter(|(index, _)| belongs(index)).collect();
        file.section(name);
        file.set("SupportedObjects", objects.len());
        for (number, (index, _)) in (1..).zip(&objects) {
            file.set(number, format_args!("0x{index:04X}"));
        }
        for (index, object) in objects {
            self.object(file, parameters, *index, object);
        }
    }

    fn object(&self, file: &mut File, parameters: &Parameters, index: u16, object: &Described) {
        file.section(format_args!("{index:04X}"));
        file.set("ParameterName", &object.name);
        let is_list = matches!(object.code, ObjectCode::Array | ObjectCode::Record);
        // A DOMAIN is a VAR of type DOMAIN: some readers do not know its own object code.
        let code = if is_list { object.code } else { ObjectCode::Var };
        file.set("ObjectType", format_args!("0x{:X}", code as u8));
        if is_list {
            file.set("SubNumber", format_args!("0x{:X}", object.values.len()));
            for value in &object.values {
                file.section(format_args!("{index:04X}sub{:X}", value.sub));
                file.set("ParameterName", &value.name);
                file.set("ObjectType", format_args!("0x{:X}", ObjectCode::Var as u8));
                self.value(file, parameters, index, value);
            }
        } else {
            object.values.iter().for_each(|value| self.value(file, parameters, index, value));
        }
    }

    fn value(&self, file: &mut File, parameters: &Parameters, index: u16, value: &Value) {
        let (entry, data_type, at) = (value.entry, value.entry.data_type, (index, value.sub));
        file.set("DataType", format_args!("0x{:04X}", data_type.index()));
        let (low, high) = value.limits();
        if let Some(low) = low {
            file.set("LowLimit", value::limit(data_type, low));
        }
        if let Some(high) = high {
            file.set("HighLimit", value::limit(data_type, high));
        }
        file.set("AccessType", access(entry.access));
        if let Some(default) = self.defaults.get(&at) {
            file.set("DefaultValue", default);
        }
        if let Some(parameter) = parameters.get(&at) {
            file.set("ParameterValue", parameter);
        }
        file.flag("PDOMapping", entry.is_mappable());
    }
}

fn commissioned(file: &mut File, commissioning: &Commissioning, serial: u64) {
    // The standard's own spelling.
    file.section("DeviceComissioning");
    file.set("NodeID", commissioning.node.get());
    file.set("NodeName", &commissioning.name);
    file.set("Baudrate", commissioning.bit_rate);
    file.set("NetNumber", commissioning.network);
    file.set("NetworkName", &commissioning.network_name);
    file.flag("CANopenManager", commissioning.manager);
    file.set("LSS_SerialNumber", format_args!("0x{serial:08X}"));
}

fn values(dictionary: &Dictionary) -> impl Iterator<Item = ((u16, u8), &Value)> {
    dictionary
        .iter()
        .flat_map(|(&index, object)| object.values.iter().map(move |value| ((index, value.sub), value)))
}

fn access(access: Access) -> &'static str {
    match access {
        Access::Ro => "ro",
        Access::Wo => "wo",
        Access::Rw => "rw",
        Access::Rwr => "rwr",
        Access::Rww => "rww",
        Access::Const => "const",
    }
}
