//! Fuzzes everything that reads what a stranger may have written.
//!
//! ```sh
//! cargo run --release --example fuzz                                       # all readers, 10⁶ inputs each
//! cargo run --release --example fuzz -- --reader exr --executions 5000000 --seed 2
//! cargo run --release --example fuzz -- --reader exr target/fuzz/exr-0.exr # inputs that were found
//! ```
//!
//! Valid files are damaged at random, in bytes, words, lines, numbers and JSON values, and read. An
//! input may become a scene, which then has to be fit for the GPU, or one line that says what is
//! wrong. A panic, more than 5 s, or more memory than 64 MiB and 1000 times the input's size is a
//! failure: the input is written to `--failures`, and the exit code is 1. The slowest input is
//! written there in any case.
//! A crash that ends the process leaves its input in the folder that the first line names.

mod harness;
mod memory;
mod watch;

use clap::Parser;
use harness::{Inputs, Reader, Workplace, execute, kind};
use std::collections::HashSet;
use std::path::PathBuf;
use std::time::Instant;

#[global_allocator]
static ALLOCATOR: memory::Counting = memory::Counting;

/// Fuzzes the readers of scenes, meshes and maps.
#[derive(Debug, Parser)]
struct Arguments {
    /// The reader: toml, numbers, gltf, glb, ply, obj, hdr, exr or validate; all when left out.
    #[arg(long, value_parser = reader)]
    reader: Option<Reader>,
    /// Inputs per reader.
    #[arg(long, default_value_t = 1_000_000)]
    executions: u64,
    /// Which inputs.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for inputs that fail.
    #[arg(long, default_value = "target/fuzz")]
    failures: PathBuf,
    /// Inputs to read in place of random ones.
    inputs: Vec<PathBuf>,
}

const READERS: [Reader; 9] = [
    Reader::Toml,
    Reader::Numbers,
    Reader::Gltf,
    Reader::Glb,
    Reader::Ply,
    Reader::Obj,
    Reader::Hdr,
    Reader::Exr,
    Reader::Validate,
];

fn reader(name: &str) -> Result<Reader, String> {
    let found = READERS.into_iter().find(|r| r.name() == name);
    found.ok_or_else(|| format!("expected one of {}", READERS.map(Reader::name).join(", ")))
}

fn main() -> std::io::Result<std::process::ExitCode> {
    let arguments = Arguments::parse();
    std::fs::create_dir_all(&arguments.failures)?;
    std::panic::set_hook(Box::new(|_| {}));
    let readers = arguments.reader.map_or(READERS.to_vec(), |r| vec![r]);
    let mut failures = 0;
    for reader in readers {
        failures += fuzz(reader, &arguments)?;
    }
    Ok(u8::from(failures > 0).into())
}

/// Runs one reader; returns how many kinds of failures there were.
fn fuzz(reader: Reader, arguments: &Arguments) -> std::io::Result<usize> {
    let place = Workplace::new(reader)?;
    let name = reader.name();
    println!("{name}: the input at hand is {}", place.input().display());
    let kept = |number: &str| {
        let name = format!("{name}-{number}.{}", reader.extension());
        arguments.failures.join(name)
    };
    watch::start(place.input(), kept("hang"));
    let mut run = Run::default();
    let start = Instant::now();
    if !arguments.inputs.is_empty() {
        for path in &arguments.inputs {
            let input = std::fs::read(path)?;
            println!("{}: {:?}", path.display(), run.execute(&place, &input));
        }
        return Ok(run.failures.len());
    }
    let mut inputs = Inputs::new(reader, arguments.seed);
    for _ in 0..arguments.executions {
        let input = inputs.next();
        match run.execute(&place, &input) {
            Ok(Some(message)) => inputs.refused(&input, &message),
            Ok(None) => {}
            Err(problem) => {
                if run.failures.insert(kind(&problem)) {
                    let path = kept(&run.failures.len().to_string());
                    std::fs::write(&path, &input)?;
                    println!("{}: {problem}", path.display());
                }
            }
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    std::fs::write(kept("slowest"), &run.slowest)?;
    println!(
        "{name}: {} inputs, {:.0} per second; {} scenes; {} kinds of messages; longest {:.0} ms; most memory {:.1} MiB; {} kinds of failures",
        arguments.executions,
        arguments.executions as f64 / seconds,
        run.scenes,
        inputs.kinds(),
        1e3 * run.longest,
        run.most_bytes as f64 / f64::from(1 << 20),
        run.failures.len()
    );
    Ok(run.failures.len())
}

/// What came of the inputs so far.
#[derive(Debug, Default)]
struct Run {
    scenes: u64,
    longest: f64,
    slowest: Vec<u8>,
    most_bytes: usize,
    failures: HashSet<String>,
}

impl Run {
    fn execute(&mut self, place: &Workplace, input: &[u8]) -> Result<Option<String>, String> {
        watch::begin();
        let (before, start) = (memory::start(), Instant::now());
        let outcome = execute(place, input);
        let bytes = memory::most().saturating_sub(before);
        watch::end();
        let seconds = start.elapsed().as_secs_f64();
        if seconds > self.longest {
            self.longest = seconds;
            self.slowest = input.to_vec();
        }
        self.most_bytes = self.most_bytes.max(bytes);
        self.scenes += u64::from(outcome == Ok(None));
        if bytes > (64 << 20) + 1000 * input.len() {
            let mib = bytes >> 20;
            return Err(format!("takes {mib} MiB for {} bytes", input.len()));
        }
        outcome
    }
}
