//! Colours of a waveform's picture. It brings its own paper, so that it looks the same on light and on dark ground.

use crate::drawing::paint::Sheet;

/// Classes of the picture.
pub(super) const SHEETS: &[Sheet] = &["
paper { fill: #ffffff; rx: 8 }
border { fill: none; stroke: #d0d5dd; rx: 8 }
title { fill: #1b2330; font-size: 15; font-weight: 600 }
node { fill: #1b2330; font-size: 13; font-weight: 600 }
soft { fill: #667085; font-size: 11 }
middle { text-anchor: middle }
end { text-anchor: end }
grid { stroke: #e9ecf1 }
zero { stroke: #98a2b3 }
name { fill: #1b2330; font-size: 10.5; text-anchor: middle }
narrow { fill: #1b2330; font-size: 8.5; text-anchor: middle }
stuff { fill: #f59e0b; fill-opacity: 0.3 }
digit { fill: #475467; font-size: 9; text-anchor: middle }
stuffed { font-weight: bold }
tx { fill: none; stroke: #2563b0; stroke-width: 1.8; stroke-linejoin: round }
rx { fill: none; stroke: #3b4454; stroke-width: 1.5; stroke-linejoin: round }
sends { fill: #2563b0; font-size: 10; text-anchor: end }
sees { fill: #3b4454; font-size: 10; text-anchor: end }
drives { fill: #2563b0; fill-opacity: 0.13 }
sample { fill: #0f8577 }
flip { fill: none; stroke: #c4232f; stroke-width: 1.8 }
resync { fill: #9333ea; fill-opacity: 0.55 }
leader { stroke: #98a2b3; stroke-dasharray: 2,2 }
leader-error { stroke: #c4232f; stroke-dasharray: 2,2 }
leader-shift { stroke: #9333ea; stroke-dasharray: 2,2 }
note { fill: #344054; font-size: 11; stroke: #ffffff; stroke-width: 3; stroke-linejoin: round; paint-order: stroke }
note-error { fill: #b01c28; font-weight: 600; font-size: 11; stroke: #ffffff; stroke-width: 3; stroke-linejoin: round; paint-order: stroke }
note-shift { fill: #7e22ce; font-size: 11; stroke: #ffffff; stroke-width: 3; stroke-linejoin: round; paint-order: stroke }
band { stroke: #ffffff; stroke-width: 1 }
sof { fill: #c9ced8 }
id { fill: #c7dcfa }
control { fill: #ddd7f6 }
dlc { fill: #c6e8e2 }
data { fill: #fdecb8 }
crc { fill: #d7e8bd }
fixed { fill: #e6e9ee }
ack { fill: #a9dfb8 }
between { fill: #f2f4f7 }
flag { fill: #f2918a }
passive { fill: #fbd3cf }
overload { fill: #eeb2dd }
superposition { fill: #f9c29b }
delimiter { fill: #f6e0da }
"];
