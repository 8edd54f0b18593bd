//! PLY files (Turk, "The PLY Polygon File Format", 1994): vertices with optional normals, as ascii or
//! binary little endian. Other elements and properties are read over.

use super::PointCloud;
use nalgebra::{Point3, Unit, Vector3};

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlyEncoding {
    /// Decimal text, exact for f64.
    Ascii,
    /// Eight-byte IEEE numbers, lowest byte first.
    BinaryLittleEndian,
}

/// A PLY file that cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlyError {
    /// Not a PLY file at all.
    #[error("file does not start with `ply`")]
    Magic,
    /// The header does not end.
    #[error("PLY header has no `end_header` line")]
    NoHeaderEnd,
    /// A header line makes no sense.
    #[error("PLY header line {line} is `{found}`, expected {wanted}")]
    Header {
        /// Number of the line, from 1.
        line: usize,
        /// The line.
        found: String,
        /// What was expected.
        wanted: &'static str,
    },
    /// There are no points, or they lack a coordinate.
    #[error("PLY vertices have properties {found:?}, expected x, y and z among them")]
    NoCoordinates {
        /// Properties of the vertex element.
        found: Vec<String>,
    },
    /// The data end early.
    #[error("PLY data end in element `{element}` at row {row} of {n_rows}")]
    Truncated {
        /// The element being read.
        element: String,
        /// The row that is not whole, from 0.
        row: usize,
        /// Rows the header promises.
        n_rows: usize,
    },
    /// A word of an ascii file is not a number.
    #[error("PLY element `{element}` row {row} has `{found}`, expected a number")]
    Number {
        /// The element being read.
        element: String,
        /// The row, from 0.
        row: usize,
        /// The word found.
        found: String,
    },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }
}

enum Shape {
    Single,
    List { count: Scalar },
}

struct Property {
    name: String,
    scalar: Scalar,
    shape: Shape,
}

struct Element {
    name: String,
    n_rows: usize,
    properties: Vec<Property>,
}

/// The vertices of a PLY file. Normals are kept when all three components are there; zero-length ones
/// become +z so that the counts agree.
///
/// # Errors
/// [`PlyError`] when the header or data are malformed.
pub fn parse_ply(bytes: &[u8]) -> Result<PointCloud, PlyError> {
    let (encoding, elements, body) = parse_header(bytes)?;
    let mut words = match encoding {
        PlyEncoding::Ascii => Source::Ascii(
            body.split(|b| b.is_ascii_whitespace())
                .filter(|word| !word.is_empty())
                .collect(),
        ),
        PlyEncoding::BinaryLittleEndian => Source::Binary(body),
    };
    for element in &elements {
        if element.name == "vertex" {
            return read_vertices(element, &mut words);
        }
        for row in 0..element.n_rows {
            read_row(element, row, &mut words, |_, _| {})?;
        }
    }
    Err(PlyError::NoCoordinates { found: Vec::new() })
}

fn read_vertices(element: &Element, source: &mut Source<'_>) -> Result<PointCloud, PlyError> {
    let column = |name: &str| element.properties.iter().position(|p| p.name == name);
    let columns = ["x", "y", "z", "nx", "ny", "nz"].map(column);
    let [Some(x), Some(y), Some(z), nx, ny, nz] = columns else {
        let found = element.properties.iter().map(|p| p.name.clone()).collect();
        return Err(PlyError::NoCoordinates { found });
    };
    // Not reserved from the header: a false count must not take memory.
    let mut points = Vec::new();
    let mut normals = Vec::new();
    let mut values = vec![0.0; element.properties.len()];
    for row in 0..element.n_rows {
        read_row(element, row, source, |property, value| {
            values[property] = value
        })?;
        points.push(Point3::new(values[x], values[y], values[z]));
        if let (Some(nx), Some(ny), Some(nz)) = (nx, ny, nz) {
            let normal = Vector3::new(values[nx], values[ny], values[nz]);
            normals.push(Unit::try_new(normal, f64::EPSILON).unwrap_or_else(Vector3::z_axis));
        }
    }
    let has_normals = nx.is_some() && ny.is_some() && nz.is_some();
    Ok(PointCloud {
        points,
        normals: has_normals.then_some(normals),
    })
}

fn read_row(
    element: &Element,
    row: usize,
    source: &mut Source<'_>,
    mut store: impl FnMut(usize, f64),
) -> Result<(), PlyError> {
    for (i, property) in element.properties.iter().enumerate() {
        match property.shape {
            Shape::Single => store(i, source.next(property.scalar, element, row)?),
            Shape::List { count } => {
                let n = source.next(count, element, row)?;
                for _ in 0..n.max(0.0) as u64 {
                    source.next(property.scalar, element, row)?;
                }
            }
        }
    }
    Ok(())
}

enum Source<'a> {
    Ascii(std::collections::VecDeque<&'a [u8]>),
    Binary(&'a [u8]),
}

impl Source<'_> {
    fn next(&mut self, scalar: Scalar, element: &Element, row: usize) -> Result<f64, PlyError> {
        let truncated = || PlyError::Truncated {
            element: element.name.clone(),
            row,
            n_rows: element.n_rows,
        };
        match self {
            Self::Ascii(words) => {
                let word = words.pop_front().ok_or_else(truncated)?;
                let word = String::from_utf8_lossy(word);
                word.parse().map_err(|_parse| PlyError::Number {
                    element: element.name.clone(),
                    row,
                    found: word.into_owned(),
                })
            }
            Self::Binary(rest) => take_scalar(rest, scalar).ok_or_else(truncated),
        }
    }
}

fn take_scalar(rest: &mut &[u8], scalar: Scalar) -> Option<f64> {
    fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
        let (head, tail) = rest.split_first_chunk::<N>()?;
        *rest = tail;
        Some(*head)
    }
    Some(match scalar {
        Scalar::I8 => f64::from(i8::from_le_bytes(take(rest)?)),
        Scalar::U8 => f64::from(u8::from_le_bytes(take(rest)?)),
        Scalar::I16 => f64::from(i16::from_le_bytes(take(rest)?)),
        Scalar::U16 => f64::from(u16::from_le_bytes(take(rest)?)),
        Scalar::I32 => f64::from(i32::from_le_bytes(take(rest)?)),
        Scalar::U32 => f64::from(u32::from_le_bytes(take(rest)?)),
        Scalar::F32 => f64::from(f32::from_le_bytes(take(rest)?)),
        Scalar::F64 => f64::from_le_bytes(take(rest)?),
    })
}

fn parse_header(bytes: &[u8]) -> Result<(PlyEncoding, Vec<Element>, &[u8]), PlyError> {
    let mut rest = bytes;
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    for line in 1.. {
        let Some(end) = rest.iter().position(|&b| b == b'\n') else {
            return Err(if line == 1 {
                PlyError::Magic
            } else {
                PlyError::NoHeaderEnd
            });
        };
        let text = String::from_utf8_lossy(&rest[..end]).trim_end().to_owned();
        rest = &rest[end + 1..];
        let wrong = |wanted| PlyError::Header {
            line,
            found: text.clone(),
            wanted,
        };
        let words: Vec<&str> = text.split_whitespace().collect();
        match words.as_slice() {
            ["ply"] if line == 1 => {}
            _ if line == 1 => return Err(PlyError::Magic),
            ["format", "ascii", "1.0"] => encoding = Some(PlyEncoding::Ascii),
            ["format", "binary_little_endian", "1.0"] => {
                encoding = Some(PlyEncoding::BinaryLittleEndian);
            }
            ["format", ..] => {
                return Err(wrong(
                    "`format ascii 1.0` or `format binary_little_endian 1.0`",
                ));
            }
            ["comment" | "obj_info", ..] | [] => {}
            ["element", name, n_rows] => elements.push(Element {
                name: (*name).to_owned(),
                n_rows: n_rows
                    .parse()
                    .map_err(|_parse| wrong("`element NAME COUNT`"))?,
                properties: Vec::new(),
            }),
            ["property", words @ ..] => {
                let property = parse_property(words).ok_or_else(|| {
                    wrong("`property TYPE NAME` or `property list TYPE TYPE NAME`")
                })?;
                let element = elements
                    .last_mut()
                    .ok_or_else(|| wrong("an element first"))?;
                element.properties.push(property);
            }
            ["end_header"] => {
                let encoding = encoding.ok_or_else(|| wrong("a format line first"))?;
                return Ok((encoding, elements, rest));
            }
            _ => {
                return Err(wrong(
                    "`format`, `element`, `property`, `comment` or `end_header`",
                ));
            }
        }
    }
    Err(PlyError::NoHeaderEnd)
}

fn parse_property(words: &[&str]) -> Option<Property> {
    match words {
        ["list", count, scalar, name] => Some(Property {
            name: (*name).to_owned(),
            scalar: Scalar::parse(scalar)?,
            shape: Shape::List {
                count: Scalar::parse(count)?,
            },
        }),
        [scalar, name] => Some(Property {
            name: (*name).to_owned(),
            scalar: Scalar::parse(scalar)?,
            shape: Shape::Single,
        }),
        _ => None,
    }
}

/// A cloud as the bytes of a PLY file, in f64.
#[must_use]
pub fn format_ply(cloud: &PointCloud, encoding: PlyEncoding) -> Vec<u8> {
    let format = match encoding {
        PlyEncoding::Ascii => "ascii",
        PlyEncoding::BinaryLittleEndian => "binary_little_endian",
    };
    let names: &[&str] = if cloud.normals.is_some() {
        &["x", "y", "z", "nx", "ny", "nz"]
    } else {
        &["x", "y", "z"]
    };
    let properties: String = names
        .iter()
        .map(|name| format!("property double {name}\n"))
        .collect();
    let header = format!(
        "ply\nformat {format} 1.0\nelement vertex {}\n{properties}end_header\n",
        cloud.len()
    );
    let mut bytes = header.into_bytes();
    for (i, point) in cloud.points.iter().enumerate() {
        let normal = cloud.normals.as_ref().map(|normals| normals[i]);
        let values = point
            .iter()
            .copied()
            .chain(normal.iter().flat_map(|normal| normal.iter().copied()));
        match encoding {
            PlyEncoding::Ascii => {
                let words: Vec<String> = values.map(|v| v.to_string()).collect();
                bytes.extend_from_slice(words.join(" ").as_bytes());
                bytes.push(b'\n');
            }
            PlyEncoding::BinaryLittleEndian => {
                values.for_each(|v| bytes.extend_from_slice(&v.to_le_bytes()));
            }
        }
    }
    bytes
}
