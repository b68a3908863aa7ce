//! A table of false claims in weights files, grouped by location.

use safetensors::Dtype;
use wgdenoise::Weights;

use crate::file::{File, raw, replaced, with_header};

/// The fault, the file, and a fragment of the error.
type Lie = (&'static str, Vec<u8>, &'static str);

/// Maximum length of an error text in bytes.
const LONGEST: usize = 1000;

const NO_FILE: &str = "not a whole safetensors file";

fn check(lies: Vec<Lie>) {
    for (what, bytes, expected) in lies {
        let error = Weights::from_bytes(&bytes).map(|weights| weights.metadata().clone());
        let text = error.expect_err(what).to_string();
        assert!(text.contains(expected), "{what}: `{text}` does not say `{expected}`");
        assert!(text.len() < LONGEST, "{what}: {} bytes", text.len());
        assert!(!text.chars().any(char::is_control), "{what}: {text:?}");
    }
}

fn with(change: impl FnOnce(&mut File)) -> Vec<u8> {
    let mut file = File::valid();
    change(&mut file);
    file.bytes()
}

fn meta(key: &str, value: &str) -> Vec<u8> {
    File::valid().set(key, value).bytes()
}

#[test]
fn of_the_header() {
    let valid = File::valid().bytes();
    let length = |length: u64| [&length.to_le_bytes(), &valid[8..]].concat();
    let many = (0..300_000).map(|i| format!(r#""{i}":{{}},"#));
    let many = many.collect::<Vec<_>>().concat();
    let some = (0..9000)
        .map(|i| format!(r#""extra{i}":{{"dtype":"F32","shape":[0],"data_offsets":[0,0]}},"#));
    let some = some.collect::<Vec<_>>().concat();
    check(vec![
        ("no bytes", vec![], NO_FILE),
        ("half a length", vec![9; 4], NO_FILE),
        ("a picture", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec(), "its header claims"),
        ("a PyTorch file", b"PK\x03\x04\0\0\x08\x08\0\0\0\0\0\0\0\0".to_vec(), "its header claims"),
        ("a header beyond the file", length(valid.len() as u64), NO_FILE),
        (
            "a header of 2^64 bytes",
            length(u64::MAX),
            "its header claims 18446744073709551615 bytes",
        ),
        ("a header of 1 MiB", raw(&vec![b' '; 1 << 20], b""), "claims 1048576 bytes, but fewer"),
        ("no header", raw(b"", b""), NO_FILE),
        ("text that is no JSON", raw(b"widths = 2, 3", b""), "invalid JSON in header"),
        ("text that is no UTF-8", raw(b"{\"\xff\xfe\":1}", b""), "invalid UTF-8"),
        ("brackets without end", raw(&vec![b'['; 1 << 19], b""), "invalid JSON"),
        ("more after the header's end", with_header(|header| header + "{}"), "trailing characters"),
        (
            "300000 tensors",
            with_header(|header| header.replacen('{', &format!("{{{many}"), 1)),
            "fewer",
        ),
        (
            "9000 empty tensors more",
            with_header(|header| header.replacen('{', &format!("{{{some}"), 1)),
            "(one of 9000 such)",
        ),
        ("bytes after the last tensor", [&valid[..], &[0]].concat(), NO_FILE),
        ("its last byte lacking", valid[..valid.len() - 1].to_vec(), NO_FILE),
    ]);
}

#[test]
fn of_tensors_and_their_places() {
    let first = r#""dec_conv0a.bias":{"dtype":"F32","shape":[2],"data_offsets":[0,8]}"#;
    let as_first = |text: &str| replaced(first, &first.replace("[0,8]", text));
    let of_shape = |shape: &str| replaced(first, &first.replace("[2]", shape));
    let of_type = |dtype: &str| replaced(first, &first.replace("F32", dtype));
    check(vec![
        ("two tensors in one place", as_first("[8,16]"), "invalid offset"),
        ("a hole", as_first("[4,8]"), "invalid offset for tensor `dec_conv0a.bias`"),
        ("an end before the beginning", as_first("[8,0]"), "invalid offset"),
        ("a place beyond the file", as_first("[0,4611686018427387904]"), NO_FILE),
        ("a place beyond 64 bits", as_first("[0,36893488147419103232]"), "invalid JSON"),
        ("a negative place", as_first("[-8,0]"), "invalid JSON"),
        (
            "the same name twice",
            replaced(first, &format!("{first},{}", first.replace("[0,8]", "[8,16]"))),
            "invalid offset",
        ),
        ("no shape", replaced(r#""shape":[2],"#, ""), "missing field `shape`"),
        ("more values than bytes", of_shape("[3]"), NO_FILE),
        ("no values", of_shape("[0]"), NO_FILE),
        ("more values than 64 bits count", of_shape("[4294967296,4294967296,4294967296]"), NO_FILE),
        ("2^62 values", of_shape("[4611686018427387904]"), NO_FILE),
        ("a negative side", of_shape("[-2]"), "invalid JSON"),
        ("axes of its own", of_shape("[1,2]"), "has shape [1, 2], expected [2]"),
        ("100000 axes", of_shape(&format!("[{}2]", "1,".repeat(100_000))), "has shape [1, 1, 1,"),
        ("integers", of_type("I32"), "has type I32, expected F16 or F32"),
        ("half of the bytes", of_type("F16"), NO_FILE),
        ("a type that is none", of_type("F31"), "unknown variant `F31`"),
        (
            "a type with a terminal's commands",
            of_type(r"\u001b[2J\u0007"),
            r"unknown variant `\u{1b}[2J\u{7}`",
        ),
        ("half a byte per value", of_type("F4"), NO_FILE),
    ]);
    for other in [Dtype::BF16, Dtype::F64, Dtype::I8, Dtype::U64, Dtype::BOOL] {
        let bytes = vec![0; 6 * other.bitsize() / 8];
        let lie = |file: &mut File| {
            file.tensors.insert("out_conv.weight".into(), (other, vec![3, 2, 1, 1], bytes));
        };
        check(vec![("a type that is not read", with(lie), "expected F16 or F32")]);
    }
}

#[test]
fn of_names() {
    let renamed = |to: &str| {
        with(|file| {
            let tensor = file.tensors.remove("mid_conva.bias").expect("it is there");
            file.tensors.insert(to.into(), tensor);
        })
    };
    let more = |name: &str| with(|file| file.fill(name, &[1], 0.0));
    check(vec![
        ("another case", renamed("mid_convA.bias"), "tensor `mid_conva.bias` is missing"),
        ("a blank behind", renamed("mid_conva.bias "), "tensor `mid_conva.bias` is missing"),
        ("a pool with weights", more("pool0.weight"), "tensor `pool0.weight` (one of 1 such)"),
        ("a name without letters", more(""), "tensor `` (one of 1 such)"),
        ("a name of half a megabyte", more(&"n".repeat(1 << 19)), "n…` (one of 1 such)"),
        ("a name with a terminal's commands", more("\u{1b}[2J\r\n\u{7}"), r"`\u{1b}[2J\r\n\u{7}`"),
        ("a name that is read backwards", more("a\u{202e}b"), r"`a\u{202e}b`"),
        ("a network without a name", meta("name", ""), "metadata `name` is ``, expected 1 to 64"),
        ("a network's name of 65 letters", meta("name", &"n".repeat(65)), "expected 1 to 64"),
        (
            "a network's name with commands",
            meta("name", "\u{1b}c"),
            r"metadata `name` is `\u{1b}c`",
        ),
        ("two lines as a name", meta("name", "a\nb"), r"metadata `name` is `a\nb`"),
    ]);
}

#[test]
fn of_metadata() {
    let long = "9,".repeat(1 << 18);
    let width = "metadata `widths` is `";
    let deep = "1024,1024,1024,1024,1024,1024,1024,1024";
    check(vec![
        ("none", with_header(|header| header.replacen("__metadata__", "metadata", 1)), NO_FILE),
        (
            "null",
            with_header(|h| {
                let end = h.find('}').unwrap();
                format!(r#"{{"__metadata__":null{}"#, &h[end + 1..])
            }),
            "the file has no `__metadata__`",
        ),
        ("a number for a text", replaced(r#""2,3""#, "2"), "invalid JSON in header: invalid type"),
        ("twice", replaced("{", r#"{"__metadata__":{},"#), "duplicate field `__metadata__`"),
        ("another version", meta("format_version", "1.0"), "metadata `format_version` is `1.0`"),
        (
            "a version with a blank",
            meta("format_version", "1 "),
            "metadata `format_version` is `1 `",
        ),
        ("a format's name without end", meta("format", &long), "9,…`, but this version"),
        ("widths without end", meta("widths", &long), width),
        ("a comma behind", meta("widths", "2,3,"), width),
        ("widths as floats", meta("widths", "2.0,3.0"), width),
        ("a width beyond 64 bits", meta("widths", "2,18446744073709551618"), width),
        ("digits of another script", meta("widths", "２,３"), width),
        ("one level more", meta("widths", "2,3,3"), "tensor `enc_conv1a.weight` is missing"),
        ("gigabytes that are not there", meta("widths", deep), "expected [1024, 3, 3, 3]"),
        ("an input more", meta("inputs", "color,albedo,normal"), "expected [2, 9, 3, 3]"),
        ("inputs in another order", meta("inputs", "albedo,color"), "metadata `inputs` is"),
        ("inputs with commands", meta("inputs", "\u{9b}2J"), r"metadata `inputs` is `\u{9b}2J`"),
    ]);
    for eps in ["", "0", "-0", "1", "inf", "1e-400", "1e400", "nan", "0x1p-9", "1e-5 ", "0,1"] {
        check(vec![("an eps that is none", meta("norm_eps", eps), "metadata `norm_eps` is `")]);
    }
}

#[test]
fn of_values() {
    let normed = |part: &'static str, value: f32| {
        with(|file| {
            file.norm("mid_conva", 3);
            file.fill(&format!("mid_conva.{part}"), &[3], value);
        })
    };
    let huge = with(|file| {
        file.norm("mid_conva", 3);
        file.fill("mid_conva.norm.weight", &[3], f32::MAX);
        file.fill("mid_conva.norm.running_var", &[3], 0.0);
    });
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    check(vec![
        ("a bias that is no number", normed("bias", nan), "`mid_conva.bias` has NaN at element 0"),
        ("a scale that is none", normed("norm.weight", nan), "`mid_conva.norm.weight` has NaN"),
        ("a shift that is none", normed("norm.bias", -inf), "`mid_conva.norm.bias` has -inf"),
        ("an infinite mean", normed("norm.running_mean", inf), "running_mean` has inf"),
        ("an infinite variance", normed("norm.running_var", inf), "running_var` has inf"),
        ("a negative variance", normed("norm.running_var", -1e-9), "[0] is -0.000000001, expected"),
        ("a scale that overflows", huge, "`mid_conva.weight with its norm folded in` has inf"),
    ]);
    let halves = |bits: u16| {
        with(|file| {
            let half = (Dtype::F16, vec![3], bits.to_le_bytes().repeat(3));
            file.tensors.insert("out_conv.bias".into(), half);
        })
    };
    check(vec![
        ("a half that is no number", halves(0x7e00), "`out_conv.bias` has NaN at element 0"),
        ("an infinite half", halves(0xfc00), "`out_conv.bias` has -inf at element 0"),
    ]);
    let tiny_eps = with(|file| {
        file.norm("mid_conva", 3);
        file.fill("mid_conva.norm.running_var", &[3], 0.0);
        file.metadata.insert("norm_eps".into(), "1e-300".into());
    });
    check(vec![("a division by nearly nothing", tiny_eps, "folded in` has inf")]);
}

/// Unusual but valid files.
#[test]
fn but_what_is_only_unusual_is_read() {
    let smallest = half::f16::from_bits(1);
    let subnormal = with(|file| {
        let bits = smallest.to_le_bytes().repeat(3);
        file.tensors.insert("out_conv.bias".into(), (Dtype::F16, vec![3], bits));
    });
    let bias = Weights::from_bytes(&subnormal).unwrap().params("out_conv").bias;
    assert_eq!(bias, [2.0_f32.powi(-24); 3]);

    for header_padding in 0..4 {
        let unaligned =
            with_header(|header| header.trim_end().to_string() + &" ".repeat(header_padding));
        let weights = Weights::from_bytes(&unaligned).unwrap();
        assert_eq!(weights.params("out_conv").weight, [0.25; 6]);
    }
    let beyond_half = with(|file| file.fill("out_conv.bias", &[3], f32::MAX));
    assert_eq!(Weights::from_bytes(&beyond_half).unwrap().params("out_conv").bias, [f32::MAX; 3]);

    let twice = replaced(r#""name":"test""#, r#""name":"first","name":"last""#);
    assert_eq!(Weights::from_bytes(&twice).unwrap().metadata().name, "last");
    let name = "ä".repeat(64);
    assert_eq!(Weights::from_bytes(&meta("name", &name)).unwrap().metadata().name, name);
    let long = Weights::from_bytes(&meta("provenance", &"x".repeat(1 << 19))).unwrap();
    assert_eq!(long.metadata().provenance.len(), 1 << 19);
    let zero = with(|file| {
        file.norm("mid_conva", 3);
        file.fill("mid_conva.norm.running_var", &[3], -0.0);
    });
    assert!(Weights::from_bytes(&zero).is_ok());
}
