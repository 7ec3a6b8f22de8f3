//! `handover blend`: poses of one shape (OBJ) and weights → shapes between and beyond them (OBJ).

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::bail;
use handover_mesh::Point;
use handover_mesh::blend::{BlendError, BlendSettings, Blended, Blender, Energy, Triangles};
use handover_mesh::formats::obj::Obj;
use handover_mesh::geometry::is_finite;
use handover_mesh::statistics::median;
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::args::{Blend, Weights};
use crate::files::{self, BadFile};
use crate::output::{Output, counted};
use crate::progress::Progress;
use crate::{Outcome, UsageError};

/// What came of it.
struct Found<'a> {
    settings: BlendSettings,
    blender: Blender,
    vertices: usize,
    triangles: usize,
    init_ms: f64,
    /// Of each shape.
    solve_ms: Vec<f64>,
    shapes: Vec<Shape<'a>>,
}

/// A shape that was written.
struct Shape<'a> {
    file: &'a Path,
    weights: Vec<f64>,
    blended: Blended,
}

/// Reads, blends, writes, and says what was done.
pub(crate) fn run(arguments: &Blend, output: &Output) -> anyhow::Result<Outcome> {
    let settings = arguments.settings()?;
    let weights = all_weights(arguments)?;
    let inputs: Vec<PathBuf> =
        std::iter::once(&arguments.reference).chain(&arguments.poses).cloned().collect();
    let targets = targets(arguments, weights.len());
    for target in &targets {
        files::check_out(Some(target), "obj", &inputs)?;
    }
    let Some(shapes) = read(&inputs, output)? else { return Ok(Outcome::Failed) };
    let found = blend(&inputs, &shapes, settings, weights, &targets, output)?;
    output.result(|| text(&inputs, &found), || value(&found))?;
    tell(&found, output);
    Ok(Outcome::Done)
}

/// The weights of every shape to make.
fn all_weights(arguments: &Blend) -> Result<Vec<Vec<f64>>, UsageError> {
    let poses = arguments.poses.len();
    if let Some(Weights(wrong)) = arguments.weights.iter().find(|weights| weights.0.len() != poses)
    {
        return Err(UsageError(format!(
            "-w {}: {} for {}",
            joined(wrong),
            counted(wrong.len(), "weight"),
            counted(poses, "pose")
        )));
    }
    let given = arguments.weights.iter().map(|weights| weights.0.clone());
    let Some(frames) = arguments.frames else { return Ok(given.collect()) };
    let (frames, stretches) = (frames as usize, arguments.weights.len());
    if frames <= stretches {
        return Err(UsageError(format!(
            "--frames {frames}: the reference and {} are {} frames at least",
            counted(stretches, "-w"),
            stretches + 1
        )));
    }
    let stops: Vec<Vec<f64>> = std::iter::once(vec![0.0; poses]).chain(given).collect();
    Ok(on_the_way(&stops, frames - 1))
}

/// The weights of all frames: every stop is one of them, and each stretch between two takes as many
/// steps as the others, or one more.
fn on_the_way(stops: &[Vec<f64>], steps: usize) -> Vec<Vec<f64>> {
    let stretches = stops.len() - 1;
    let mut frames = vec![stops[0].clone()];
    for (at, ends) in stops.windows(2).enumerate() {
        let count = (at + 1) * steps / stretches - at * steps / stretches;
        for step in 1..=count {
            let share = step as f64 / count as f64;
            // So written both ends are met to the bit.
            let between = |(from, to): (&f64, &f64)| (1.0 - share) * from + share * to;
            frames.push(ends[0].iter().zip(&ends[1]).map(between).collect());
        }
    }
    frames
}

/// `OUT.obj`, or `OUT_000.obj` and those that follow.
fn targets(arguments: &Blend, count: usize) -> Vec<PathBuf> {
    let out = &arguments.out;
    if count == 1 {
        return vec![out.clone()];
    }
    let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_owned();
    let digits = (count - 1).to_string().len().max(3);
    let numbered = |number: usize| {
        let mut name = part(out.file_stem());
        name.push(format!("_{number:0digits$}."));
        name.push(part(out.extension()));
        out.with_file_name(name)
    };
    (0..count).map(numbered).collect()
}

/// All shapes, the reference first; `None` if something was wrong, which was said.
///
/// # Errors
/// If a pose is not one of the reference.
fn read(paths: &[PathBuf], output: &Output) -> anyhow::Result<Option<Vec<Obj>>> {
    let progress = Progress::new(output, "reading", paths.len());
    let read: Vec<_> = paths
        .par_iter()
        .map(|path| {
            let read = files::read_obj(path);
            progress.step();
            read.map_err(|faults| BadFile { path: path.clone(), faults })
        })
        .collect();
    drop(progress);
    let (mut shapes, mut bad) = (Vec::new(), Vec::new());
    for read in read {
        match read {
            Ok(shape) => shapes.push(shape),
            Err(file) => bad.push(file),
        }
    }
    if !bad.is_empty() {
        files::name_bad(&bad, output);
        return Ok(None);
    }
    for (path, shape) in paths.iter().zip(&shapes).skip(1) {
        if let Some(difference) = shapes[0].difference(shape) {
            bail!(
                "{} and {} are not the same shape: {difference}",
                paths[0].display(),
                path.display()
            );
        }
    }
    Ok(Some(shapes))
}

/// Blends and writes one shape after another.
#[expect(clippy::disallowed_methods, reason = "a shell: how long it took is worth knowing")]
fn blend<'a>(
    inputs: &[PathBuf],
    shapes: &[Obj],
    settings: BlendSettings,
    weights: Vec<Vec<f64>>,
    targets: &'a [PathBuf],
    output: &Output,
) -> anyhow::Result<Found<'a>> {
    let reference = &shapes[0];
    let cannot = |error| cannot(&inputs[0], error);
    let positions: Vec<&[Point]> = shapes.iter().map(Obj::positions).collect();
    let vertices = reference.positions().len();
    let triangles = Triangles::new(vertices, reference.triangles()).map_err(cannot)?;
    let milliseconds = |since: Instant| since.elapsed().as_secs_f64() * 1e3;
    let start = Instant::now();
    let blender = Blender::of_triangles(&triangles, &positions, settings).map_err(cannot)?;
    let init_ms = milliseconds(start);
    let mut workspace = blender.workspace();
    let mut places = reference.positions().to_vec();
    let (mut solve_ms, mut made) = (Vec::new(), Vec::new());
    let progress = Progress::new(output, "blending", targets.len());
    for (weights, file) in weights.into_iter().zip(targets) {
        let start = Instant::now();
        let blended = blender.blend(&weights, &mut workspace, &mut places);
        solve_ms.push(milliseconds(start));
        if !places.iter().all(is_finite) {
            bail!(
                "-w {}: too far from the shapes: {} is not written, it would have places that are \
                 not finite",
                joined(&weights),
                file.display()
            );
        }
        files::write_bytes(&reference.write(&places), file)?;
        made.push(Shape { file, weights, blended });
        progress.step();
    }
    drop(progress);
    let triangles = triangles.as_slice().len();
    Ok(Found { settings, blender, vertices, triangles, init_ms, solve_ms, shapes: made })
}

/// Why not, with vertices counted as files count them.
fn cannot(reference: &Path, error: BlendError) -> anyhow::Error {
    let reference = reference.display();
    let BlendError::NotManifold { edges, vertices } = error else {
        return anyhow::Error::new(error).context(format!("cannot blend {reference}"));
    };
    let edges = edges.into_iter().map(|edge| edge.map(|vertex| vertex + 1)).collect();
    let vertices = vertices.into_iter().map(|vertex| vertex + 1).collect();
    let error = BlendError::NotManifold { edges, vertices };
    anyhow::anyhow!(
        "cannot blend {reference}: {error} (hint: --tetrisation face takes any triangles)"
    )
}

/// What is worth knowing of what was blended, though nothing is lost.
fn tell(found: &Found<'_>, output: &Output) {
    let (replaced, free) = (found.blender.replaced(), found.blender.free());
    if replaced > 0 {
        output.note(&format!(
            "note: {} took the tetrahedron over the face: no other is positive in every shape",
            counted(replaced, "triangle")
        ));
    }
    if free > 0 {
        output.note(&format!(
            "note: {} in no tetrahedron: the weighted mean of the shapes",
            several(free, "vertex is", "vertices are")
        ));
    }
    if found.settings.energy == Energy::Transforms {
        return;
    }
    let most = found.settings.iterations;
    let whole = found.shapes.iter().filter(|shape| !shape.blended.is_settled);
    let count = whole.clone().count();
    let change = |shape: &&Shape<'_>| shape.blended.change;
    if let Some(worst) = whole.max_by(|a, b| change(a).total_cmp(&change(b))) {
        output.note(&format!(
            "note: {count} of {} took all of {} without coming to rest, and may be far from where \
             more would end: in the last a vertex of {} moved by {:.1e}, at most {:.1e} is rest \
             (hint: --iterations)",
            counted(found.shapes.len(), "shape"),
            counted(most, "iteration"),
            worst.file.display(),
            worst.blended.change,
            found.blender.at_rest(),
        ));
    }
}

fn text(inputs: &[PathBuf], found: &Found<'_>) -> String {
    let BlendSettings { tetrisation, rotation, energy, .. } = found.settings;
    let mut text = format!(
        "{} of {}: {}, {}\n{} over each {}, {} left out; energy {}, rotation {}\n",
        counted(inputs.len() - 1, "pose"),
        inputs[0].display(),
        several(found.vertices, "vertex", "vertices"),
        counted(found.triangles, "triangle"),
        several(found.blender.tetrahedra(), "tetrahedron", "tetrahedra"),
        tetrisation.name(),
        found.blender.flipped(),
        energy.name(),
        rotation.name(),
    );
    let median_of = match found.solve_ms.len() {
        1 => String::new(),
        several => format!(" (median of {several})"),
    };
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "init {:.1} ms, solve {:.2} ms{median_of}",
        found.init_ms,
        median(found.solve_ms.clone()).unwrap_or(f64::NAN)
    );
    for Shape { file, weights, blended } in &found.shapes {
        let iterations = match energy {
            Energy::Transforms => String::new(),
            _ => format!("  {}", counted(blended.iterations, "iteration")),
        };
        let _ = writeln!(
            text,
            "{}  weights {}  energy {:.4e}{iterations}",
            file.display(),
            joined(weights),
            blended.energy,
        );
    }
    text
}

fn value(found: &Found<'_>) -> Value {
    let BlendSettings { tetrisation, rotation, energy, iterations, tolerance } = found.settings;
    let shapes = found.shapes.iter().map(|Shape { file, weights, blended }| {
        json!({
            "file": file.display().to_string(),
            "weights": weights,
            "iterations": blended.iterations,
            "energy": blended.energy,
            "change": blended.change,
            "settled": blended.is_settled,
        })
    });
    let iterative = energy != Energy::Transforms;
    json!({
        "init_ms": found.init_ms,
        "solve_ms": median(found.solve_ms.clone()),
        "iterations": found.shapes.iter().map(|shape| shape.blended.iterations).max(),
        "flipped": found.blender.flipped(),
        "replaced": found.blender.replaced(),
        "free": found.blender.free(),
        "tetrahedra": found.blender.tetrahedra(),
        "vertices": found.vertices,
        "triangles": found.triangles,
        "tetrisation": tetrisation.name(),
        "energy": energy.name(),
        "rotation": rotation.name(),
        "most_iterations": iterative.then_some(iterations),
        "tolerance": iterative.then_some(tolerance),
        "at_rest": iterative.then_some(found.blender.at_rest()),
        "shapes": shapes.collect::<Vec<_>>(),
    })
}

/// `0.5,-1`.
fn joined(weights: &[f64]) -> String {
    weights.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

/// `1 vertex`, `2 vertices`.
fn several(count: usize, one: &str, more: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { more })
}
