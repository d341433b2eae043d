//! What is at the path of an input: mostly a file, now and then what no reader expects.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use std::path::Path;

/// What is at a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// A file with the bytes of the input.
    File,
    /// A file of no bytes.
    Empty,
    /// Nothing.
    Nothing,
    /// A folder with nothing in it.
    Folder,
    /// A folder that holds the input and a link to itself.
    FullFolder,
    /// A link to a file with the input.
    Link,
    /// A link to nothing.
    Dangling,
    /// A link to itself.
    Loop,
    /// A pipe that nobody writes to.
    Pipe,
    /// A device that never ends.
    Device,
}

impl Place {
    /// A file in 49 of 50 cases.
    pub fn random(random: &mut ChaCha8Rng) -> Self {
        if random.random_range(0..50) > 0 {
            return Self::File;
        }
        [
            Self::Empty,
            Self::Nothing,
            Self::Folder,
            Self::FullFolder,
            Self::Link,
            Self::Dangling,
            Self::Loop,
            Self::Pipe,
            Self::Device,
        ][random.random_range(0..9)]
    }

    /// Puts it at a path, in place of what is there.
    ///
    /// # Errors
    /// That of the operating system.
    pub fn put(self, path: &Path, bytes: &[u8]) -> std::io::Result<()> {
        match std::fs::symlink_metadata(path) {
            Ok(there) if there.is_dir() => std::fs::remove_dir_all(path)?,
            Ok(_) => std::fs::remove_file(path)?,
            Err(_) => {}
        }
        match self {
            Self::File => std::fs::write(path, bytes),
            Self::Empty => std::fs::write(path, []),
            Self::Nothing => Ok(()),
            Self::Folder => std::fs::create_dir(path),
            Self::FullFolder => {
                std::fs::create_dir(path)?;
                let name = path.file_name().unwrap_or_default();
                std::fs::write(path.join(name), bytes)?;
                link(path, &path.join("again"))
            }
            Self::Link => {
                let there = path.with_file_name("linked");
                std::fs::write(&there, bytes)?;
                link(&there, path)
            }
            Self::Dangling => link(&path.with_file_name("nothing"), path),
            Self::Loop => link(path, path),
            Self::Pipe => std::process::Command::new("mkfifo").arg(path).status().map(drop),
            Self::Device => link(Path::new("/dev/zero"), path),
        }
    }
}

#[cfg(unix)]
fn link(to: &Path, at: &Path) -> std::io::Result<()> {
    std::os::unix::fs::symlink(to, at)
}

#[cfg(not(unix))]
fn link(_to: &Path, at: &Path) -> std::io::Result<()> {
    std::fs::write(at, [])
}
