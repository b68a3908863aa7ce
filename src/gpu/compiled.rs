//! Compiled pipelines with a header that proves their origin.

/// Bytes that [`get_data`](wgpu::PipelineCache::get_data) returned for the same key, as far as a
/// hash can tell.
pub(crate) struct Compiled<'a>(&'a [u8]);

impl<'a> Compiled<'a> {
    /// The data after the header; `None` if the bytes are damaged or belong to another key.
    pub(crate) fn open(key: &str, bytes: &'a [u8]) -> Option<Self> {
        // The header's length does not depend on the data.
        let data = bytes.get(header(key, &[]).len()..)?;
        bytes.starts_with(&header(key, data)).then_some(Self(data))
    }

    /// Prepends the header to a driver's data.
    pub(crate) fn seal(key: &str, data: &[u8]) -> Vec<u8> {
        [&header(key, data), data].concat()
    }

    pub(crate) fn data(&self) -> &'a [u8] {
        self.0
    }
}

fn header(key: &str, data: &[u8]) -> Vec<u8> {
    let (length, hash) = (data.len(), fnv1a(data));
    format!("wgdenoise pipelines\n{key}\n{length:016x} {hash:016x}\n").into_bytes()
}

/// Every step is a bijection, so changing one byte always changes the hash.
fn fnv1a(data: &[u8]) -> u64 {
    let step = |hash: u64, &byte: &u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    data.iter().fold(0xcbf2_9ce4_8422_2325, step)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DATA: &[u8] = b"\0compiled\n\xff";

    fn opened(key: &str, bytes: &[u8]) -> Option<Vec<u8>> {
        Compiled::open(key, bytes).map(|compiled| compiled.data().to_vec())
    }

    #[test]
    fn bytes_are_read_with_their_own_key_alone() {
        let bytes = Compiled::seal("driver 1.0", DATA);
        assert_eq!(opened("driver 1.0", &bytes).as_deref(), Some(DATA));
        assert_eq!(opened("driver 1.1", &bytes), None);
        assert_eq!(opened("k", &Compiled::seal("k", b"")).as_deref(), Some(&b""[..]));
    }

    #[test]
    fn damaged_bytes_are_ignored() {
        let whole = Compiled::seal("key", DATA);
        let cut = (0..whole.len()).map(|end| whole[..end].to_vec());
        let flipped = (0..whole.len()).map(|at| {
            let mut bytes = whole.clone();
            bytes[at] ^= 4;
            bytes
        });
        let longer = [&whole[..], b"\0"].concat();
        for damaged in cut.chain(flipped).chain([longer, DATA.to_vec(), b"WGPUPLCH".to_vec()]) {
            assert_eq!(opened("key", &damaged), None, "{damaged:?}");
        }
    }
}
