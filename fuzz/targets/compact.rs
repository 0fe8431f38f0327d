//! Plans, parameters and states in the compact form: as it is, and with a head
//! and a checksum that are right around a body that nobody would write.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    faregate_fuzz::plan("fuzzed.bin", bytes);
    if let Some(sealed) = sealed(bytes) {
        faregate_fuzz::plan("sealed.bin", &sealed);
    }
});

/// The same kind and body, with everything around them as a writer makes it.
fn sealed(bytes: &[u8]) -> Option<Vec<u8>> {
    let (head, rest) = bytes.split_first_chunk::<15>()?;
    let (body, _) = rest.split_last_chunk::<4>()?;
    let mut file = Vec::from(*b"\xF5plan\r\n\x1A\x01\0");
    file.push(head[10]);
    file.extend_from_slice(&u32::try_from(body.len()).ok()?.to_le_bytes());
    file.extend_from_slice(body);
    file.extend_from_slice(&crc32fast::hash(&file).to_le_bytes());
    Some(file)
}
