//! A render in progress, shown elsewhere: in files that are written again and again, and in the
//! viewer tev.

use crate::outputs::OutputArguments;
use direkt::error::{Error, GpuError, number};
use direkt::low_level::console::say;
use direkt::low_level::output;
use direkt::low_level::render::passes::duration;
use direkt::low_level::render::{Film, Session};
use direkt::scene::Scene;
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

/// Time between two pictures in a viewer.
const VIEWER: Duration = Duration::from_millis(250);
/// How often the time that a picture takes has to pass before the next one.
const PATIENCE: u32 = 20;
const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// Where a render in progress is shown.
#[derive(Debug, clap::Args)]
pub struct LiveArguments {
    /// Write the outputs again while rendering, every 2 seconds or as many as given; AOVs come at
    /// the end
    #[arg(
        long,
        value_name = "SECONDS",
        num_args = 0..=1,
        default_missing_value = "2",
        require_equals = true,
        requires = "output"
    )]
    watch: Option<f64>,
    /// Show the image while rendering in the viewer tev, which usually listens at 127.0.0.1:14158
    #[arg(long, value_name = "HOST:PORT")]
    tev: Option<String>,
}

/// What shows a render in progress.
pub struct Live<'a> {
    outputs: &'a OutputArguments,
    /// Time between two writings of the outputs.
    interval: Option<Duration>,
    written: Timer,
    /// Whether the outputs could be written the last time.
    is_writable: bool,
    viewer: Option<Viewer>,
    sent: Timer,
}

impl<'a> Live<'a> {
    /// Connects to the viewer, if there is to be one.
    ///
    /// # Errors
    /// An argument makes no sense, or nobody listens.
    pub fn new(
        arguments: &LiveArguments,
        outputs: &'a OutputArguments,
        scene: &Scene,
    ) -> Result<Self, Error> {
        if let Some(seconds) = arguments.watch.filter(|s| !(*s > 0.0 && s.is_finite())) {
            return Err(Error::Usage(format!(
                "--watch={}: a positive number of seconds is needed",
                number(seconds)
            )));
        }
        let viewer = arguments.tev.as_ref();
        Ok(Self {
            outputs,
            interval: arguments.watch.map(duration),
            written: Timer::default(),
            is_writable: true,
            viewer: viewer.map(|at| Viewer::new(at, scene)).transpose()?,
            sent: Timer::default(),
        })
    }

    /// Shows the image of `session` where it is time for it.
    ///
    /// # Errors
    /// The driver fails.
    pub fn look(&mut self, session: &Session<'_>) -> Result<(), GpuError> {
        let write = self.interval.is_some_and(|i| self.written.is_due(i));
        let send = self.viewer.is_some() && self.sent.is_due(VIEWER);
        if !write && !send {
            return Ok(());
        }
        let start = Instant::now();
        let film = session.snapshot()?.0;
        if write {
            self.write(&film, session.samples());
            self.written = Timer::since(start);
        }
        if send {
            self.send(&film);
            self.sent = Timer::since(start);
        }
        Ok(())
    }

    /// Writes the outputs. They are written again and at the end, so that a failure is a warning,
    /// and is told once.
    fn write(&mut self, film: &Film, samples: u64) {
        let attributes = [("spp", samples.to_string())];
        let mut is_writable = true;
        for (path, bytes) in self.outputs.encode(film, &[], &attributes) {
            if let Err(error) = bytes.and_then(|bytes| output::write(path, &bytes)) {
                if self.is_writable {
                    say(format_args!("direkt: warning: --watch: {error}"));
                }
                is_writable = false;
            }
        }
        self.is_writable = is_writable;
    }

    /// Shows the image that is done.
    pub fn end(&mut self, film: &Film) {
        self.send(film);
    }

    /// Sends the image to the viewer; one that has gone is missed once.
    fn send(&mut self, film: &Film) {
        let Some(viewer) = &mut self.viewer else {
            return;
        };
        if let Err(error) = viewer.send(film) {
            say(format_args!(
                "direkt: warning: --tev {}: {error}; going on without",
                viewer.at
            ));
            self.viewer = None;
        }
    }
}

/// When something was done the last time, and how long it took.
#[derive(Debug, Default)]
struct Timer(Option<(Instant, Duration)>);

impl Timer {
    fn since(start: Instant) -> Self {
        Self(Some((Instant::now(), start.elapsed())))
    }

    /// Whether `interval` has passed, and long enough that it takes a small part of the time.
    fn is_due(&self, interval: Duration) -> bool {
        self.0
            .is_none_or(|(at, took)| at.elapsed() >= interval.max(PATIENCE * took))
    }
}

/// A viewer that listens.
struct Viewer {
    at: String,
    client: TevClient,
    image: String,
    is_created: bool,
}

impl Viewer {
    fn new(at: &str, scene: &Scene) -> Result<Self, Error> {
        let socket = TcpStream::connect(at).map_err(|error| {
            Error::Usage(format!(
                "--tev {at}: {error}; start tev first, which listens at 127.0.0.1:14158 unless it is told otherwise"
            ))
        })?;
        Ok(Self {
            at: at.to_owned(),
            client: TevClient::wrap(socket),
            image: format!("direkt: {}", scene.source.display()),
            is_created: false,
        })
    }

    fn send(&mut self, film: &Film) -> std::io::Result<()> {
        let (width, height) = (film.size.width, film.size.height);
        if !self.is_created {
            self.client.send(PacketCreateImage {
                image_name: &self.image,
                grab_focus: true,
                width,
                height,
                channel_names: &CHANNELS,
            })?;
            self.is_created = true;
        }
        let values = film.pixels.iter();
        let values: Vec<f32> = values.flat_map(|p| p.mean.map(|x| x as f32)).collect();
        self.client.send(PacketUpdateImage {
            image_name: &self.image,
            grab_focus: false,
            channel_names: &CHANNELS,
            channel_offsets: &[0, 1, 2],
            channel_strides: &[3, 3, 3],
            x: 0,
            y: 0,
            width,
            height,
            data: &values,
        })
    }
}
