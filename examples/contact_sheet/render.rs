//! Triangles → shaded dots: parallel projection, a depth for each dot, one light.

use handover_mesh::formats::obj::Obj;
use handover_mesh::geometry::{Point, Vector, direction_or};

use crate::font;

/// Dots that become one, both ways, so that edges are smooth.
const FINE: usize = 3;

/// From where one looks.
pub(crate) struct View {
    /// To the right, up, and towards whoever looks.
    axes: [Vector; 3],
}

impl View {
    /// - `turn`: to the right of the z axis `[°]`; `tilt`: above the ground `[°]`.
    pub(crate) fn new(turn: f64, tilt: f64) -> Self {
        let (turn, tilt) = (turn.to_radians(), tilt.to_radians());
        let right = Vector::new(turn.cos(), 0.0, -turn.sin());
        let ahead = Vector::new(turn.sin() * tilt.cos(), tilt.sin(), turn.cos() * tilt.cos());
        Self { axes: [right, ahead.cross(&right), ahead] }
    }

    /// A shape as it looks from there.
    pub(crate) fn of(&self, obj: &Obj) -> Seen {
        let place = |point: &Point| self.axes.map(|axis| axis.dot(&point.coords));
        Seen { places: obj.positions().iter().map(place).collect(), triangles: obj.triangles() }
    }
}

/// A shape from one side.
pub(crate) struct Seen {
    /// To the right, up, and towards whoever looks.
    places: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Seen {
    /// The least and the largest along an axis.
    fn range(&self, axis: usize) -> [f64; 2] {
        self.places.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[least, largest], place| {
            [least.min(place[axis]), largest.max(place[axis])]
        })
    }

    /// How wide and how high it is.
    pub(crate) fn size(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.range(axis)).map(|[least, largest]| largest - least)
    }
}

/// Rows of red, green and blue, white at first.
pub(crate) struct Picture {
    pub(crate) width: usize,
    pub(crate) height: usize,
    dots: Vec<u8>,
}

impl Picture {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self { width, height, dots: vec![255; 3 * width * height] }
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        &self.dots
    }

    fn set(&mut self, [x, y]: [usize; 2], colour: [u8; 3]) {
        if x < self.width && y < self.height {
            self.dots[3 * (y * self.width + x)..][..3].copy_from_slice(&colour);
        }
    }

    /// Draws a shape into the middle of a field; `scale` is in dots a unit.
    pub(crate) fn shape(&mut self, seen: &Seen, from: [usize; 2], size: [usize; 2], scale: f64) {
        let field = Field::of(seen, size, scale * FINE as f64);
        for y in 0..size[1] {
            for x in 0..size[0] {
                self.set([from[0] + x, from[1] + y], field.mean([x, y]));
            }
        }
    }

    /// Draws a line of text into the middle of a width, as much as there is room for.
    pub(crate) fn text(&mut self, text: &str, from: [usize; 2], [width, letter]: [usize; 2]) {
        let step = letter * font::WIDTH;
        let shown: Vec<char> = text.chars().take(width / step).collect();
        let left = from[0] + (width - shown.len() * step) / 2;
        for (at, letter_shown) in shown.iter().enumerate() {
            for y in 0..letter * font::HEIGHT {
                for x in 0..step {
                    if font::dot(*letter_shown, x / letter, y / letter) {
                        self.set([left + at * step + x, from[1] + y], [40; 3]);
                    }
                }
            }
        }
    }
}

/// One shape in fine dots.
struct Field {
    width: usize,
    height: usize,
    depths: Vec<f64>,
    colours: Vec<[f64; 3]>,
}

impl Field {
    fn of(seen: &Seen, size: [usize; 2], scale: f64) -> Self {
        let [width, height] = size.map(|length| length * FINE);
        let count = width * height;
        let mut field = Self {
            width,
            height,
            depths: vec![f64::NEG_INFINITY; count],
            colours: vec![[255.0; 3]; count],
        };
        let [x, y] =
            [0, 1].map(|axis| seen.range(axis)).map(|[least, largest]| (least + largest) / 2.0);
        let place = |vertex: u32| {
            let [right, up, depth] = seen.places[vertex as usize];
            let across = width as f64 / 2.0 + (right - x) * scale;
            Vector::new(across, height as f64 / 2.0 - (up - y) * scale, depth * scale)
        };
        for triangle in &seen.triangles {
            field.triangle(triangle.map(place));
        }
        field
    }

    fn triangle(&mut self, [a, b, c]: [Vector; 3]) {
        // y points down here, so that what turns left seen from the front has a negative depth.
        let normal = (b - a).cross(&(c - a));
        if normal.z == 0.0 || !normal.z.is_finite() {
            return;
        }
        let colour = colour(normal);
        let least = |axis: usize| a[axis].min(b[axis]).min(c[axis]).floor().max(0.0) as usize;
        let most = |axis: usize| a[axis].max(b[axis]).max(c[axis]).ceil().max(0.0) as usize;
        for y in least(1)..most(1).min(self.height) {
            for x in least(0)..most(0).min(self.width) {
                let dot = Vector::new(x as f64 + 0.5, y as f64 + 0.5, 0.0);
                let side = |from: Vector, to: Vector| {
                    ((to.x - from.x) * (dot.y - from.y) - (to.y - from.y) * (dot.x - from.x))
                        / normal.z
                };
                let shares = [side(b, c), side(c, a), side(a, b)];
                let depth = shares[0] * a.z + shares[1] * b.z + shares[2] * c.z;
                let at = y * self.width + x;
                if shares.iter().all(|share| *share >= 0.0) && depth > self.depths[at] {
                    self.depths[at] = depth;
                    self.colours[at] = colour;
                }
            }
        }
    }

    /// The colour of a dot: that of all its fine ones.
    fn mean(&self, [x, y]: [usize; 2]) -> [u8; 3] {
        let mut sum = [0.0; 3];
        for row in FINE * y..FINE * (y + 1) {
            for column in FINE * x..FINE * (x + 1) {
                let colour = self.colours[row * self.width + column];
                sum.iter_mut().zip(colour).for_each(|(sum, colour)| *sum += colour);
            }
        }
        sum.map(|sum| (sum / (FINE * FINE) as f64) as u8)
    }
}

/// What a surface looks like that faces this way (right, down, towards whoever looks).
fn colour(normal: Vector) -> [f64; 3] {
    let front = normal.z < 0.0;
    let towards = if front { -normal } else { normal };
    let normal = direction_or(Vector::new(towards.x, -towards.y, towards.z), Vector::z());
    // From above on the left, over the shoulder of whoever looks.
    let light = direction_or(Vector::new(-0.4, 0.6, 0.7), Vector::z());
    // What faces away from the light is still told apart.
    let bright = 0.3 + 0.7 * (0.5 + 0.5 * normal.dot(&light)).powf(1.5);
    let base = if front { [236.0, 214.0, 178.0] } else { [220.0, 60.0, 50.0] };
    base.map(|part| part * bright)
}
