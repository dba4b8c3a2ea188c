//! `docs/your-own.md`, followed to the letter in a fresh folder outside the repository.
//!
//! Two things differ: the repository is where it is and not at `../ecss-can`, and the twin takes free ports.

use std::fs;

use interop::page::{Folder, Step, steps};
use interop::program::Twin;
use interop::tools;

const REPOSITORY: &str = "../ecss-can";
const FREE_PORTS: &str = " --slcan-nominal 0 --slcan-redundant 0";
const NOMINAL: &str = "socket://127.0.0.1:29501";

#[test]
fn every_step_of_the_page_works() {
    let page = fs::read_to_string(tools::workspace().join("docs/your-own.md")).unwrap();
    let repository = tools::workspace().display().to_string();
    assert!(page.contains(REPOSITORY));
    let top = tempfile::tempdir().unwrap();
    let python = tools::python().unwrap_or_else(|failure| panic!("{failure:#}"));
    let mut folder = Folder::new(top.path(), python.parent().unwrap());
    follow(&steps(&page.replace(REPOSITORY, &repository)).unwrap(), &mut folder)
        .unwrap_or_else(|failure| panic!("{failure:#}"));
    let top = top.path();
    let sheet = fs::read_to_string(top.join("heater/heater.eds")).unwrap();
    assert!(sheet.contains("ParameterName=Setpoint") && sheet.contains("HighLimit=850"), "{sheet}");
}

fn follow(steps: &[Step], folder: &mut Folder) -> anyhow::Result<()> {
    let (mut twin, mut said): (Option<Twin>, String) = (None, String::new());
    for step in steps {
        match step {
            Step::File(path, text) if path.extension().is_some_and(|name| name == "py") => {
                let twin = twin.as_ref().expect("the spacecraft flies before its client is written");
                assert!(text.contains(NOMINAL), "{text}");
                folder.write(path, &text.replace(NOMINAL, &twin.nominal))?;
            }
            Step::File(path, text) => folder.write(path, text)?,
            Step::Run(commands) => said = folder.run(commands)?,
            Step::Background(command) => {
                let command = folder.background(&(command.trim_end().to_owned() + FREE_PORTS));
                twin = Some(Twin::of(command)?);
            }
            Step::Output(expected) => assert!(said.ends_with(expected), "{said}"),
        }
    }
    let said = twin.expect("a spacecraft that flies").end()?;
    assert!(said.contains("slave 5"), "{said}");
    Ok(())
}
