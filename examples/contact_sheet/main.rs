//! Pictures of shapes (OBJ) side by side, all at one scale: `OUT.png NAME=FILE.obj...`.
//!
//! `--columns N` says how many stand in a row, `--turn DEGREES` from how far right of the z axis
//! one looks (30), `--tilt DEGREES` from how far above (15), `--cell PIXELS` how wide each is (480).
//! y is up. What is seen from its back, as where a surface is turned inside out, is red.

mod font;
mod render;

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use handover_mesh::formats::obj::Obj;

use render::{Picture, View};

const USAGE: &str = "usage: contact_sheet [--columns N] [--turn DEGREES] [--tilt DEGREES] [--cell PIXELS] \
    OUT.png [NAME=]FILE.obj...";

struct Arguments {
    out: PathBuf,
    /// What each is called, and its file.
    shapes: Vec<(String, PathBuf)>,
    columns: Option<usize>,
    turn: f64,
    tilt: f64,
    cell: usize,
}

fn main() -> ExitCode {
    let Err(error) = run() else { return ExitCode::SUCCESS };
    // Where stderr is closed there is nobody left to tell.
    let _ = writeln!(std::io::stderr(), "error: {error}");
    ExitCode::FAILURE
}

fn run() -> Result<(), Box<dyn Error>> {
    let Arguments { out, shapes, columns, turn, tilt, cell } = arguments()?;
    let view = View::new(turn, tilt);
    let mut read = Vec::new();
    for (name, path) in &shapes {
        let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let obj = Obj::read(&bytes).map_err(|error| format!("{}: {error}", path.display()))?;
        read.push((name, obj));
    }
    let columns = columns.unwrap_or_else(|| (1..).find(|n| n * n >= read.len()).unwrap_or(1));
    let rows = read.len().div_ceil(columns);
    let seen: Vec<_> = read.iter().map(|(_, obj)| view.of(obj)).collect();
    let size = seen
        .iter()
        .map(render::Seen::size)
        .fold([0.0; 2], |a, b| [f64::max(a[0], b[0]), f64::max(a[1], b[1])]);
    let letter = (cell / 160).max(1);
    let margin = cell / 24;
    let caption = letter * (font::HEIGHT + 4);
    let scale = ((cell - 2 * margin) as f64 / size[0].max(f64::MIN_POSITIVE))
        .min(cell as f64 / size[1].max(f64::MIN_POSITIVE));
    let height = (size[1] * scale).ceil() as usize + margin + caption;
    let mut picture = Picture::new(columns * cell, rows * height);
    for (at, (seen, (name, _))) in seen.iter().zip(&read).enumerate() {
        let [left, top] = [at % columns * cell, at / columns * height];
        let [width, below] = [cell, height - caption];
        picture.shape(seen, [left, top], [width, below], scale);
        picture.text(name, [left, top + below + letter], [width, letter]);
    }
    write(&picture, &out)?;
    writeln!(std::io::stdout(), "{}: {} by {}", out.display(), picture.width, picture.height)?;
    Ok(())
}

fn write(picture: &Picture, out: &Path) -> Result<(), Box<dyn Error>> {
    let file = BufWriter::new(File::create(out)?);
    let [width, height] = [u32::try_from(picture.width)?, u32::try_from(picture.height)?];
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(picture.bytes())?;
    Ok(writer.finish()?)
}

fn arguments() -> Result<Arguments, Box<dyn Error>> {
    let (mut options, mut named) = ([None; 4], Vec::new());
    let mut given = std::env::args().skip(1);
    while let Some(argument) = given.next() {
        match ["--columns", "--turn", "--tilt", "--cell"].iter().position(|o| *o == argument) {
            Some(option) => {
                let value = given.next().ok_or(USAGE)?;
                let number: f64 =
                    value.parse().map_err(|_| format!("{argument} {value}: {USAGE}"))?;
                options[option] = Some(number);
            }
            None => named.push(argument),
        }
    }
    let [columns, turn, tilt, cell] = options;
    if named.len() < 2 {
        return Err(USAGE.into());
    }
    let out = PathBuf::from(named.remove(0));
    let shape = |argument: String| match argument.split_once('=') {
        Some((name, path)) => (name.to_owned(), path.into()),
        None => {
            let path = PathBuf::from(argument);
            (path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), path)
        }
    };
    Ok(Arguments {
        out,
        shapes: named.into_iter().map(shape).collect(),
        columns: columns.map(|columns| columns.clamp(1.0, 1e3) as usize),
        turn: turn.unwrap_or(30.0),
        tilt: tilt.unwrap_or(15.0),
        cell: cell.unwrap_or(480.0).clamp(48.0, 4096.0) as usize,
    })
}
