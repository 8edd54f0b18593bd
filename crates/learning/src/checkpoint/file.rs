//! Named tensors and a header in one file.

use std::collections::{BTreeMap, HashMap};
use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;

use rand_chacha::ChaCha8Rng;
use safetensors::{Dtype, SafeTensors, tensor::TensorView};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use super::{CheckpointError, Header, other, rng_of_bytes};
use crate::mlp::Mlp;
use crate::panels::Lanes;

/// The one entry of metadata: several would lie in the order of a hash map.
const KEY: &str = "factotum";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sealed<H> {
    sha256: String,
    header: H,
}

/// One tensor as it lies in the file.
#[derive(Debug)]
pub(super) struct Stored {
    dtype: Dtype,
    shape: Vec<usize>,
    bytes: Vec<u8>,
}

impl Stored {
    pub(super) fn of_bytes(bytes: Vec<u8>) -> Self {
        Self {
            dtype: Dtype::U8,
            shape: vec![bytes.len()],
            bytes,
        }
    }

    pub(super) fn of_floats(shape: &[usize], values: impl Iterator<Item = f32>) -> Self {
        Self {
            dtype: Dtype::F32,
            shape: shape.to_vec(),
            bytes: values.flat_map(f32::to_le_bytes).collect(),
        }
    }

    fn kind(&self) -> String {
        format!("{:?} {:?}", self.dtype, self.shape)
    }
}

/// Tensors by name.
#[derive(Debug)]
pub(super) struct Tensors(BTreeMap<String, Stored>);

impl Tensors {
    pub(super) fn new() -> Self {
        Self(BTreeMap::new())
    }

    pub(super) fn insert(&mut self, name: String, stored: Stored) {
        self.0.insert(name, stored);
    }

    fn take(
        &mut self,
        path: &Path,
        name: &str,
        dtype: Dtype,
        shape: &[usize],
    ) -> Result<Vec<u8>, CheckpointError> {
        let wanted = format!("a tensor `{name}` of {dtype:?} {shape:?}");
        let stored = self.take_any(path, name)?;
        if stored.dtype != dtype || stored.shape != shape {
            return Err(other(path, "a tensor of", &stored.kind(), &wanted));
        }
        Ok(stored.bytes)
    }

    fn take_any(&mut self, path: &Path, name: &str) -> Result<Stored, CheckpointError> {
        let wanted = format!("a tensor `{name}`");
        self.0
            .remove(name)
            .ok_or_else(|| other(path, "no tensor", &format!("`{name}`"), &wanted))
    }

    pub(super) fn take_bytes(
        &mut self,
        path: &Path,
        name: &str,
    ) -> Result<Vec<u8>, CheckpointError> {
        let stored = self.take_any(path, name)?;
        if stored.dtype != Dtype::U8 || stored.shape.len() != 1 {
            return Err(other(
                path,
                "a tensor of",
                &stored.kind(),
                &format!("`{name}` of bytes"),
            ));
        }
        Ok(stored.bytes)
    }

    pub(super) fn take_floats(
        &mut self,
        path: &Path,
        name: &str,
        shape: &[usize],
    ) -> Result<Vec<f32>, CheckpointError> {
        let bytes = self.take(path, name, Dtype::F32, shape)?;
        let (numbers, _) = bytes.as_chunks::<4>();
        Ok(numbers
            .iter()
            .map(|bytes| f32::from_le_bytes(*bytes))
            .collect())
    }

    pub(super) fn take_rng(
        &mut self,
        path: &Path,
        name: &str,
    ) -> Result<ChaCha8Rng, CheckpointError> {
        let bytes = self.take_bytes(path, name)?;
        let found = bytes.len();
        bytes.as_array().and_then(rng_of_bytes).ok_or_else(|| {
            other(
                path,
                "a generator of bytes",
                &found.to_string(),
                &super::RNG_BYTES.to_string(),
            )
        })
    }

    /// Takes numbers that lie as a network's parameters do.
    pub(super) fn take_into(
        &mut self,
        path: &Path,
        prefix: &str,
        network: &Mlp,
        lanes: &mut [Lanes],
    ) -> Result<(), CheckpointError> {
        for tensor in network.tensors() {
            let name = format!("{prefix}.{}", tensor.name);
            let values = self.take_floats(path, &name, &tensor.block.shape())?;
            let mut values = values.into_iter();
            tensor.block.for_each_mut(lanes, |to| {
                if let Some(value) = values.next() {
                    *to = value;
                }
            });
        }
        Ok(())
    }

    pub(super) fn check_empty(&self, path: &Path) -> Result<(), CheckpointError> {
        match self.0.keys().next() {
            Some(name) => Err(other(
                path,
                "a tensor",
                &format!("`{name}`"),
                "none of this name",
            )),
            None => Ok(()),
        }
    }

    fn digest(&self, header: &str) -> String {
        let mut hash = Sha256::new();
        let mut add = |bytes: &[u8]| {
            hash.update((bytes.len() as u64).to_le_bytes());
            hash.update(bytes);
        };
        add(header.as_bytes());
        for (name, stored) in &self.0 {
            add(name.as_bytes());
            add(stored.kind().as_bytes());
            add(&stored.bytes);
        }
        hash.finalize()
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect()
    }
}

pub(super) fn write(
    path: &Path,
    header: &Header,
    tensors: &Tensors,
) -> Result<(), CheckpointError> {
    let bytes = encode(header, tensors).map_err(|source| failed("write", path, source))?;
    write_whole(path, &bytes).map_err(|source| failed("write", path, source))
}

fn encode(header: &Header, tensors: &Tensors) -> std::io::Result<Vec<u8>> {
    let sealed = Sealed {
        sha256: tensors.digest(&serde_json::to_string(header)?),
        header,
    };
    let views = tensors
        .0
        .iter()
        .map(|(name, stored)| {
            TensorView::new(stored.dtype, stored.shape.clone(), &stored.bytes)
                .map(|view| (name.as_str(), view))
        })
        .collect::<Result<Vec<_>, _>>()
        .map_err(std::io::Error::other)?;
    let metadata = HashMap::from([(KEY.to_owned(), serde_json::to_string(&sealed)?)]);
    safetensors::serialize(views, Some(metadata)).map_err(std::io::Error::other)
}

/// Writes beside the place, brings it to the disk, and renames.
fn write_whole(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    let part = path.with_file_name(name);
    let written = File::create(&part)
        .and_then(|mut file| {
            file.write_all(bytes)?;
            file.sync_all()
        })
        .and_then(|()| fs::rename(&part, path));
    if let Err(error) = written {
        // The part is of no use; that it cannot be removed either is no news beside the first error.
        drop(fs::remove_file(&part));
        return Err(error);
    }
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
}

pub(super) fn read(path: &Path) -> Result<(Header, Tensors), CheckpointError> {
    let bytes = fs::read(path).map_err(|source| failed("read", path, source))?;
    decode(&bytes).map_err(|found| CheckpointError::Damaged {
        path: path.to_owned(),
        found,
    })
}

fn decode(bytes: &[u8]) -> Result<(Header, Tensors), String> {
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|error| error.to_string())?;
    let sealed = metadata
        .metadata()
        .as_ref()
        .and_then(|entries| entries.get(KEY))
        .ok_or_else(|| format!("no metadata `{KEY}`"))?;
    let sealed: Sealed<Header> = serde_json::from_str(sealed).map_err(|error| error.to_string())?;
    let stored = SafeTensors::deserialize(bytes).map_err(|error| error.to_string())?;
    let tensors = Tensors(
        stored
            .iter()
            .map(|(name, view)| {
                let stored = Stored {
                    dtype: view.dtype(),
                    shape: view.shape().to_vec(),
                    bytes: view.data().to_vec(),
                };
                (name.to_owned(), stored)
            })
            .collect(),
    );
    let header = serde_json::to_string(&sealed.header).map_err(|error| error.to_string())?;
    let found = tensors.digest(&header);
    if found != sealed.sha256 {
        return Err(format!(
            "its SHA-256 is {found}, and {} is written in it",
            sealed.sha256
        ));
    }
    Ok((sealed.header, tensors))
}

fn failed(act: &'static str, path: &Path, source: std::io::Error) -> CheckpointError {
    CheckpointError::Io {
        act,
        path: path.to_owned(),
        source,
    }
}
