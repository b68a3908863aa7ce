use proptest::prelude::*;

use super::*;

fn frames(text: &str) -> Vec<i64> {
    parse(text).unwrap().0
}

fn pattern(name: &str) -> Pattern {
    Pattern::parse(name.as_ref()).unwrap().expect(name)
}

fn parsed(name: &str) -> Result<Option<Pattern>, String> {
    Pattern::parse(name.as_ref())
}

fn frame(pattern: &Pattern, name: &str) -> Option<i64> {
    pattern.frame(name.as_ref())
}

#[test]
fn frames_ranges_and_steps_come_out_in_ascending_order_and_once() {
    assert_eq!(frames("60,1-4, 70-81x5"), [1, 2, 3, 4, 60, 70, 75, 80]);
    assert_eq!(frames("3-5,4,4294967295"), [3, 4, 5, MAX_FRAME]);
    assert_eq!(frames("0010"), [10]);
    assert_eq!(frames("-3-3"), [-3, -2, -1, 0, 1, 2, 3]);
    assert_eq!(frames("-3--1,-0,-10--5x5,-4294967295"), [-MAX_FRAME, -10, -5, -3, -2, -1, 0]);
    assert_eq!(frames("0-999999").len(), 1_000_000);
    assert_eq!(frames("0-4294967295x4294967295"), [0, MAX_FRAME]);
}

#[test]
fn what_names_no_frames_is_refused_with_the_reason() {
    for (text, words) in [
        ("", "`` is not a frame"),
        ("1,,2", "`` is not a frame"),
        ("1-", "`1-` is not a frame"),
        ("-", "`-` is not a frame"),
        ("--5", "`--5` is not a frame"),
        ("-1-", "`-1-` is not a frame"),
        ("-1---1", "`-1---1` is not a frame"),
        ("1-9x-2", "a step of -2"),
        ("-1--2", "runs backwards"),
        ("-4294967296", "below -4294967295"),
        ("é-1", "`é-1` is not a frame"),
        ("1-2-3", "`1-2-3` is not a frame"),
        ("1x2x3", "`1x2x3` is not a frame"),
        ("1-9x", "`1-9x` is not a frame"),
        ("a", "`a` is not a frame"),
        ("+1", "`+1` is not a frame"),
        ("1-9x0", "a step of 0"),
        ("9-1", "runs backwards"),
        ("4294967296", "above 4294967295"),
        ("0-1000000", "names 1000001 frames"),
        ("0-4294967295,0-4294967295", "names 8589934592 frames"),
    ] {
        let error = parse(text).unwrap_err();
        assert!(error.contains(words), "{text}: {error}");
    }
}

#[test]
fn missing_frames_are_shown_as_ranges() {
    assert_eq!(shown(&[-2, -1, 1, 2, 3, 7, 9, 10]), "-2--1,1-3,7,9-10");
    let every_second: Vec<i64> = (0..100_000).map(|i| 2 * i).collect();
    assert!(shown(&every_second).ends_with("34,36,38 and 99980 more"));
}

#[test]
fn both_notations_for_a_frame_number_mean_the_same() {
    for name in ["beauty.####.exr", "beauty.%04d.exr"] {
        let pattern = pattern(name);
        assert_eq!(pattern.name(7), "beauty.0007.exr");
        assert_eq!(pattern.name(123_456), "beauty.123456.exr");
        assert_eq!(frame(&pattern, "beauty.0007.exr"), Some(7));
        assert_eq!(frame(&pattern, "beauty.123456.exr"), Some(123_456));
        for other in [
            "beauty.7.exr",
            "beauty.00007.exr",
            "beauty.-000.exr",
            "beauty.0001.25.exr",
            "beauty.+007.exr",
            "beauty.exr",
            "x.0007.exr",
        ] {
            assert_eq!(frame(&pattern, other), None, "{other}");
        }
    }
    for name in ["#", "%d", "%01d"] {
        assert_eq!((pattern(name).name(0), frame(&pattern(name), "12")), ("0".into(), Some(12)));
    }
}

#[test]
fn negative_frames_are_written_as_each_notation_does_and_read_in_both() {
    let [hashes, printf] = ["b.####.exr", "b.%04d.exr"].map(pattern);
    assert_eq!((hashes.name(-3), printf.name(-3)), ("b.-0003.exr".into(), "b.-003.exr".into()));
    for pattern in [hashes, printf] {
        assert_eq!(frame(&pattern, "b.-0003.exr"), Some(-3));
        assert_eq!(frame(&pattern, "b.-003.exr"), Some(-3));
        assert_eq!(frame(&pattern, "b.-3.exr"), None);
    }
}

#[test]
fn subframes_and_other_paddings_are_near_and_other_names_are_not() {
    let pattern = pattern("b.####.exr");
    for name in ["b.0001.25.exr", "b.1.exr", "b.-1.exr", "b.00001.exr", "b.+001.exr"] {
        assert!(pattern.is_near(name.as_ref()), "{name}");
    }
    for name in ["b.0001.exr", "b.-0001.exr", "b.exr", "b.crypto.exr", "b.-.exr", "a.0001.25.exr"] {
        assert!(!pattern.is_near(name.as_ref()), "{name}");
    }
}

#[test]
fn brackets_make_a_character_plain() {
    let with_take = pattern("take[#]2.####.100[%]d.exr");
    assert_eq!(with_take.name(7), "take#2.0007.100%d.exr");
    assert_eq!(frame(&with_take, "take#2.0007.100%d.exr"), Some(7));
    for (name, is) in [("take#2", "take#2"), ("take[#][#]2", "take##2"), ("100%d[%]d", "100%d%d")] {
        assert_eq!(plain(name.as_ref()), *is);
        assert!(!has_padded_place(name.as_ref()), "{name}");
    }
    for name in ["##", "a.%04d.exr", "take#2.####"] {
        assert!(has_padded_place(name.as_ref()), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn a_name_need_not_be_unicode() {
    use std::os::unix::ffi::OsStrExt;
    let pattern = Pattern::parse(OsStr::from_bytes(b"caf\xe9.##.exr")).unwrap().unwrap();
    let name = pattern.name(7);
    assert_eq!(name.as_bytes(), b"caf\xe9.07.exr");
    assert_eq!(pattern.frame(&name), Some(7));
}

#[test]
fn a_name_has_one_place_for_a_frame_number_or_none() {
    for name in ["", "a.exr", "100%.exr", "%4d.exr", "%0d.exr", "%s.exr", "%04", "%.exr%"] {
        assert_eq!(parsed(name), Ok(None), "{name}");
    }
    for name in ["#.#.exr", "##_%d.exr", "%d%d", "%04d.#"] {
        assert!(parsed(name).unwrap_err().contains("two places"), "{name}");
    }
    for name in ["%033d", "%099999999999999999999999d", &"#".repeat(33)] {
        assert!(parsed(name).unwrap_err().contains("at most 32"), "{name}");
    }
    assert_eq!(pattern("%%04d.exr").name(1), "%0001.exr");
}

proptest! {
    #[test]
    fn a_name_is_read_back_as_its_frame(frame: i32, digits in 1..12_usize, text in "[a-z0-9._]*") {
        let pattern = pattern(&format!("{text}{}.exr", "#".repeat(digits)));
        let frame = i64::from(frame);
        prop_assert_eq!(pattern.frame(&pattern.name(frame)), Some(frame));
    }

    #[test]
    fn what_is_shown_reads_back(mut numbers in prop::collection::vec(-20..20_i64, 1..40)) {
        numbers.sort_unstable();
        numbers.dedup();
        prop_assert_eq!(parse(&shown(&numbers)), Ok(Frames(numbers)));
    }

    #[test]
    fn no_text_makes_it_panic(text in ".*", name in ".*") {
        let _ = parse(&text);
        let (text, name) = (OsString::from(text), OsString::from(name));
        let _ = (plain(&text), has_padded_place(&text));
        if let Ok(Some(pattern)) = Pattern::parse(&text) {
            let _ = (pattern.frame(&name), pattern.is_near(&name));
        }
    }
}
