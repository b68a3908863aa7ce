use super::*;
use crate::Problem;

#[test]
fn integers_and_missing_blocks_are_refused_in_one_sentence() {
    let folder = Folder::new();
    let path = folder.with(&karma(Compression::ZIP16, Blocks::ScanLines));
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 10]).unwrap();
    let error = Picture::open(&path, &LayerChoice::default()).unwrap_err();
    assert!(matches!(error.problem, Problem::Damaged(_)), "{error}");
    assert!(error.to_string().ends_with("1 of 7 blocks are missing"), "{error}");

    let n = SIZE.0 * SIZE.1;
    let ids = || FlatSamples::U32(vec![1; n]);
    let encoding = Encoding::FAST_LOSSLESS;
    let color = layer("C", SIZE, encoding, ["R", "G", "B"].map(|c| (c, ids())).to_vec());
    let image = AnyImage {
        attributes: ImageAttributes::with_size(SIZE),
        layer_data: SmallVec::from_vec(vec![color]),
    };
    let error = Picture::open(&folder.with(&image), &LayerChoice::default()).unwrap_err();
    assert!(error.to_string().contains("channel `R` holds integers"), "{error}");
}

#[test]
fn an_albedo_of_integers_is_left_out_with_a_notice_unless_it_was_named() {
    let folder = Folder::new();
    let mut image = karma(Compression::ZIP16, Blocks::ScanLines);
    for channel in &mut image.layer_data[1].channel_data.list {
        channel.sample_data = FlatSamples::U32(vec![1; 20 * 10]);
    }
    let path = folder.with(&image);
    let picture = open(&path);
    assert!(picture.first().albedo().is_none() && picture.first().normal().is_some());
    let explained = &picture.first().selection().unwrap().explanation;
    assert_eq!(explained[1], "no albedo");
    let said = &picture.notices()[0];
    assert!(said.contains("`albedo` is left out: channel"), "{said}");
    let asked_for = LayerChoice { albedo: Some("albedo".into()), ..LayerChoice::default() };
    let error = Picture::open(&path, &asked_for).unwrap_err().to_string();
    assert!(error.contains("holds integers"), "{error}");
}

/// Cuts the file at every length and flips bits everywhere: an error or a picture, never a
/// panic, and no allocation beyond what the file can back.
#[test]
fn no_damage_makes_it_panic() {
    for compression in [
        Compression::ZIP16,
        Compression::PIZ,
        Compression::RLE,
        Compression::DWAA(None),
        Compression::B44A,
        Compression::PXR24,
    ] {
        let folder = Folder::new();
        let path = folder.with(&karma(compression, Blocks::ScanLines));
        let bytes = std::fs::read(&path).unwrap();
        let mut refused = 0;
        for round in 0..120_usize {
            let mut damaged = bytes.clone();
            let at = (round * 7919 + round * round * 31) % bytes.len();
            let at = if round % 2 == 0 { at } else { at % 900 };
            if round % 3 == 0 {
                damaged.truncate(at);
            } else {
                damaged[at] ^= 1 << (round % 8);
            }
            std::fs::write(&path, &damaged).unwrap();
            refused += usize::from(Picture::open(&path, &LayerChoice::default()).is_err());
        }
        assert!(refused > 39, "{compression}: only {refused} were refused");
    }
}

/// Otherwise a few bytes of the table could each become a large block of the output.
#[test]
fn blocks_that_share_bytes_are_refused_even_where_nothing_is_read() {
    let folder = Folder::new();
    let path = folder.with(&karma(Compression::ZIP16, Blocks::ScanLines));
    let mut bytes = std::fs::read(&path).unwrap();
    // The table of 7 offsets ends where the first block begins.
    let is_table = |at: &usize| bytes[*at..*at + 8] == (*at as u64 + 7 * 8).to_le_bytes();
    let table = (0..bytes.len() - 8).find(is_table).unwrap();
    let color_alone = LayerChoice { no_aux: true, ..LayerChoice::default() };
    assert!(Picture::open(&path, &color_alone).is_ok());
    // The normals' first block replaces their second, too.
    bytes.copy_within(table + 4 * 8..table + 5 * 8, table + 5 * 8);
    std::fs::write(&path, &bytes).unwrap();
    let error = Picture::open(&path, &color_alone).unwrap_err().to_string();
    assert!(error.contains("is damaged: two blocks overlap at byte"), "{error}");
}

/// At every length below the whole, with the amount that is missing.
#[test]
fn wherever_a_file_ends_too_early_it_is_refused() {
    let folder = Folder::new();
    let tiles = Blocks::Tiles(Vec2(16, 16));
    let path = folder.with(&karma(Compression::ZIP16, tiles));
    let file = std::fs::File::options().write(true).open(&path).unwrap();
    let whole = file.metadata().unwrap().len();
    let mut most_missing = 0;
    for len in (8..whole).rev() {
        file.set_len(len).unwrap();
        let error = Picture::open(&path, &LayerChoice::default()).unwrap_err().to_string();
        assert!(error.contains(": is cut off"), "{len}: {error}");
        if let Some(missing) = error.strip_suffix(" of 20 blocks are missing") {
            let missing = missing.rsplit(' ').next().unwrap().parse::<u32>().unwrap();
            assert!(missing == most_missing || missing == most_missing + 1, "{len}: {error}");
            most_missing = missing;
        }
    }
    assert_eq!(most_missing, 20);
}
