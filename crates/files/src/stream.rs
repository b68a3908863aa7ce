//! Pipes and standard input: read once, whole, and kept in an unnamed temporary file.

use std::fs::File;
use std::io::{self, IsTerminal, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::Problem;

/// Most bytes read from a pipe: 4 GiB.
const MOST_BYTES: u64 = 4 << 30;

/// What has been read, by path, until [`forget`] or the end of the process.
static READ: Mutex<Vec<(PathBuf, File)>> = Mutex::new(Vec::new());

/// Whether a path is `-`, which stands for standard input and standard output.
#[must_use]
pub fn is_standard(path: &Path) -> bool {
    path == Path::new("-")
}

/// Whether a path is `-` for standard input, or leads to a pipe, as `/dev/stdin` may.
#[must_use]
pub fn is_stream(path: &Path) -> bool {
    is_standard(path) || is_pipe(path)
}

#[cfg(unix)]
fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    path.metadata().is_ok_and(|metadata| metadata.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_pipe(_path: &Path) -> bool {
    false
}

/// Opens what came through a pipe, from its beginning. Outside Linux, all files returned for a path
/// share their position.
///
/// # Errors
/// If it cannot be read, is longer than [`MOST_BYTES`], or the temporary folder is full.
pub(super) fn open(path: &Path) -> Result<File, Problem> {
    let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, file)) = read.iter().find(|(other, _)| other == path) {
        return again(file);
    }
    let file = match is_standard(path) {
        true if io::stdin().is_terminal() => {
            return Err(Problem::Format("is a terminal; pipe an image into it".into()));
        }
        true => keep(io::stdin().lock(), MOST_BYTES)?,
        false => keep(File::open(path).map_err(Problem::Read)?, MOST_BYTES)?,
    };
    let first = again(&file);
    read.push((path.to_path_buf(), file));
    first
}

/// Drops what came through the pipe at this path, so that it is read anew when next opened.
pub fn forget(path: &Path) {
    READ.lock().unwrap_or_else(PoisonError::into_inner).retain(|(other, _)| other != path);
}

fn again(file: &File) -> Result<File, Problem> {
    #[cfg(target_os = "linux")]
    {
        use std::os::fd::AsRawFd;
        if let Ok(file) = File::open(format!("/proc/self/fd/{}", file.as_raw_fd())) {
            return Ok(file);
        }
    }
    let mut file = file.try_clone().map_err(Problem::Read)?;
    file.rewind().map_err(Problem::Read)?;
    Ok(file)
}

/// Copies a stream into an unnamed temporary file.
fn keep(mut stream: impl Read, most: u64) -> Result<File, Problem> {
    let mut file = tempfile::tempfile().map_err(|error| full(&error))?;
    let (mut buffer, mut total) = (vec![0; 1 << 16], 0);
    loop {
        let len = match stream.read(&mut buffer) {
            Ok(0) => return Ok(file),
            Ok(len) => len,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(Problem::Read(error)),
        };
        total += len as u64;
        if total > most {
            return Err(Problem::TooLarge(format!(
                "is longer than {most} bytes, the most that is read from a pipe; give a file"
            )));
        }
        file.write_all(&buffer[..len]).map_err(|error| full(&error))?;
    }
}

/// The error that the temporary folder is full or missing.
pub(super) fn full(error: &io::Error) -> Problem {
    let folder = std::env::temp_dir();
    Problem::TooLarge(format!("cannot be kept in {}: {error}", folder.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_is_kept_up_to_the_limit() {
        let bytes: Vec<u8> = (0..200_000_u32).map(|i| i as u8).collect();
        let mut kept = keep(bytes.as_slice(), 200_000).unwrap();
        for _ in 0..2 {
            let mut read = Vec::new();
            again(&kept).unwrap().read_to_end(&mut read).unwrap();
            assert!(read == bytes);
        }
        kept.rewind().unwrap();
        let error = keep(io::repeat(1), 199_999).unwrap_err().to_string();
        assert!(error.starts_with("is longer than 199999 bytes, the most"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_is_read_once_for_all_who_open_it_until_it_is_forgotten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        assert!(is_stream(&path) && !is_stream(folder.path()) && is_stream(Path::new("-")));
        for content in ["content", "more of it"] {
            let writer = std::thread::spawn({
                let path = path.clone();
                move || std::fs::write(path, content).unwrap()
            });
            for _ in 0..2 {
                let mut text = String::new();
                open(&path).unwrap().read_to_string(&mut text).unwrap();
                assert_eq!(text, content);
            }
            writer.join().unwrap();
            forget(&path);
        }
    }
}
