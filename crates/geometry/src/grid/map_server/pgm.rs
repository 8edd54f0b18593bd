//! Grey images in the PGM formats of netpbm: P5 (binary) and P2 (text), 8 and 16 bits, with comments.

/// How pixels are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PgmEncoding {
    /// `P5`: one byte a pixel, two (high byte first) above 255.
    Binary,
    /// `P2`: decimal numbers.
    Text,
}

/// A PGM file that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PgmError {
    /// Not a grey PGM file.
    #[error("file starts with `{found}`, expected `P5` or `P2`")]
    Magic {
        /// First characters of the file.
        found: String,
    },
    /// A header field is not a number in its range.
    #[error("header field `{field}` is `{found}`, expected {wanted}")]
    Header {
        /// `width`, `height` or `maxval`.
        field: &'static str,
        /// The text found.
        found: String,
        /// What was expected.
        wanted: &'static str,
    },
    /// The pixels end early.
    #[error(
        "truncated: found {found} bytes of pixels, wanted {wanted} ({width} x {height} at {bytes_per_pixel})"
    )]
    Truncated {
        /// Bytes there are.
        found: usize,
        /// Bytes there should be.
        wanted: usize,
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// One or two.
        bytes_per_pixel: usize,
    },
    /// A text file has too few pixels.
    #[error("truncated: found {found} pixels, wanted {wanted} ({width} x {height})")]
    TruncatedText {
        /// Pixels there are.
        found: usize,
        /// Pixels there should be.
        wanted: usize,
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// A pixel is not a number up to maxval.
    #[error("pixel {pixel} is `{found}`, expected a whole number up to {maxval}")]
    Pixel {
        /// Row-major index.
        pixel: usize,
        /// The text or number found.
        found: String,
        /// Largest value.
        maxval: u16,
    },
}

/// A grey image, row 0 on top, with what its file had besides pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GrayImage {
    width: usize,
    height: usize,
    maxval: u16,
    pixels: Vec<u16>,
    encoding: PgmEncoding,
    /// Comment lines of the header, without `#`.
    comments: Vec<String>,
}

impl GrayImage {
    /// Most pixels a file may have, as many as a grid may have cells.
    const PIXELS_MAX: usize = crate::grid::OccupancyGrid::CELLS_MAX;

    /// An 8-bit image from `pixel(column, row)`, row 0 on top.
    #[must_use]
    pub fn from_rows(width: usize, height: usize, pixel: impl Fn(usize, usize) -> u16) -> Self {
        let pixels = (0..height)
            .flat_map(|row| (0..width).map(move |column| (column, row)))
            .map(|(column, row)| pixel(column, row).min(255))
            .collect();
        let comments = Vec::new();
        Self {
            width,
            height,
            maxval: 255,
            pixels,
            encoding: PgmEncoding::Binary,
            comments,
        }
    }

    /// Columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// The value of white.
    #[must_use]
    pub fn maxval(&self) -> u16 {
        self.maxval
    }

    /// The pixels, row-major from the top.
    #[must_use]
    pub fn pixels(&self) -> &[u16] {
        &self.pixels
    }

    /// One pixel.
    ///
    /// # Panics
    /// When it is outside the image.
    #[must_use]
    pub fn pixel(&self, column: usize, row: usize) -> u16 {
        assert!(
            column < self.width,
            "column {column} of an image {} wide",
            self.width
        );
        self.pixels[row * self.width + column]
    }

    /// Replaces one pixel; values above [`GrayImage::maxval`] become white.
    ///
    /// # Panics
    /// When it is outside the image.
    pub fn set_pixel(&mut self, column: usize, row: usize, value: u16) {
        assert!(
            column < self.width,
            "column {column} of an image {} wide",
            self.width
        );
        self.pixels[row * self.width + column] = value.min(self.maxval);
    }

    /// Reads the bytes of a PGM file.
    ///
    /// # Errors
    /// [`PgmError`] naming what was found and wanted.
    pub fn parse_pgm(bytes: &[u8]) -> Result<Self, PgmError> {
        let encoding = match bytes.get(..2) {
            Some(b"P5") => PgmEncoding::Binary,
            Some(b"P2") => PgmEncoding::Text,
            _ => {
                let found = String::from_utf8_lossy(&bytes[..bytes.len().min(2)]).into_owned();
                return Err(PgmError::Magic { found });
            }
        };
        let mut header = Header {
            rest: &bytes[2..],
            comments: Vec::new(),
        };
        let width = header.number("width", "a whole number of columns", Self::PIXELS_MAX)?;
        let height = header.number(
            "height",
            "a whole number of rows",
            Self::PIXELS_MAX / width.max(1),
        )?;
        let wanted = "a whole number from 1 to 65535";
        let maxval = header.number("maxval", wanted, usize::from(u16::MAX))?;
        let maxval = u16::try_from(maxval)
            .ok()
            .filter(|&maxval| maxval > 0)
            .ok_or_else(|| PgmError::Header {
                field: "maxval",
                found: maxval.to_string(),
                wanted,
            })?;
        let Header { rest, comments } = header;
        // Exactly one blank parts header and pixels: the first pixel may look like a blank.
        let body = rest.get(1..).unwrap_or_default();
        let pixels = match encoding {
            PgmEncoding::Binary => binary_pixels(body, width, height, maxval)?,
            PgmEncoding::Text => text_pixels(body, width, height, maxval)?,
        };
        if let Some(pixel) = pixels.iter().position(|&value| value > maxval) {
            let found = pixels[pixel].to_string();
            return Err(PgmError::Pixel {
                pixel,
                found,
                maxval,
            });
        }
        Ok(Self {
            width,
            height,
            maxval,
            pixels,
            encoding,
            comments,
        })
    }

    /// The bytes of a PGM file, in the encoding the image was read in.
    #[must_use]
    pub fn to_pgm(&self) -> Vec<u8> {
        let magic = match self.encoding {
            PgmEncoding::Binary => "P5",
            PgmEncoding::Text => "P2",
        };
        let comments: String = self
            .comments
            .iter()
            .map(|line| format!("#{line}\n"))
            .collect();
        let mut bytes = format!(
            "{magic}\n{comments}{} {}\n{}\n",
            self.width, self.height, self.maxval
        )
        .into_bytes();
        match self.encoding {
            PgmEncoding::Binary if self.maxval > 255 => {
                self.pixels
                    .iter()
                    .for_each(|p| bytes.extend_from_slice(&p.to_be_bytes()));
            }
            PgmEncoding::Binary => bytes.extend(self.pixels.iter().map(|&p| p as u8)),
            PgmEncoding::Text => {
                for row in self.pixels.chunks(self.width.max(1)) {
                    let words: Vec<String> = row.iter().map(ToString::to_string).collect();
                    bytes.extend_from_slice(words.join(" ").as_bytes());
                    bytes.push(b'\n');
                }
            }
        }
        bytes
    }
}

struct Header<'a> {
    rest: &'a [u8],
    comments: Vec<String>,
}

impl<'a> Header<'a> {
    fn number(
        &mut self,
        field: &'static str,
        wanted: &'static str,
        max: usize,
    ) -> Result<usize, PgmError> {
        let word = self.word();
        let text = String::from_utf8_lossy(word);
        text.parse()
            .ok()
            .filter(|&n: &usize| n <= max)
            .ok_or_else(|| PgmError::Header {
                field,
                found: text.chars().take(20).collect(),
                wanted,
            })
    }

    /// The next word; blanks and comments before it are passed over.
    fn word(&mut self) -> &'a [u8] {
        loop {
            let blanks = self
                .rest
                .iter()
                .take_while(|b| b.is_ascii_whitespace())
                .count();
            self.rest = &self.rest[blanks..];
            let Some(comment) = self.rest.strip_prefix(b"#") else {
                break;
            };
            let end = comment
                .iter()
                .position(|&b| b == b'\n')
                .unwrap_or(comment.len());
            let text = String::from_utf8_lossy(&comment[..end]);
            self.comments.push(text.trim_end_matches('\r').to_owned());
            self.rest = &comment[end..];
        }
        let end = self
            .rest
            .iter()
            .position(|b| b.is_ascii_whitespace() || *b == b'#')
            .unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        word
    }
}

fn binary_pixels(
    body: &[u8],
    width: usize,
    height: usize,
    maxval: u16,
) -> Result<Vec<u16>, PgmError> {
    let bytes_per_pixel = if maxval > 255 { 2 } else { 1 };
    let wanted = width * height * bytes_per_pixel;
    let bytes = body.get(..wanted).ok_or(PgmError::Truncated {
        found: body.len(),
        wanted,
        width,
        height,
        bytes_per_pixel,
    })?;
    Ok(if bytes_per_pixel == 2 {
        bytes
            .chunks_exact(2)
            .map(|pair| u16::from_be_bytes([pair[0], pair[1]]))
            .collect()
    } else {
        bytes.iter().map(|&byte| u16::from(byte)).collect()
    })
}

fn text_pixels(
    body: &[u8],
    width: usize,
    height: usize,
    maxval: u16,
) -> Result<Vec<u16>, PgmError> {
    let wanted = width * height;
    let text = String::from_utf8_lossy(body);
    let pixels: Vec<u16> = text
        .lines()
        .flat_map(|line| line.split('#').next().unwrap_or("").split_whitespace())
        .take(wanted)
        .enumerate()
        .map(|(pixel, word)| {
            word.parse().map_err(|_parse| PgmError::Pixel {
                pixel,
                found: word.to_owned(),
                maxval,
            })
        })
        .collect::<Result<_, _>>()?;
    if pixels.len() == wanted {
        Ok(pixels)
    } else {
        Err(PgmError::TruncatedText {
            found: pixels.len(),
            wanted,
            width,
            height,
        })
    }
}
