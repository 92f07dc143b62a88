//! Text is cut at character boundaries; invalid bytes are tolerated.

use shm_schemas::Text;

#[test]
fn long_text_is_cut_at_a_character() {
    for (given, kept) in [
        ("", ""),
        ("grip", "grip"),
        ("12345678", "12345678"),
        ("123456789", "12345678"),
        ("1234567é", "1234567"),
        ("123456é", "123456é"),
        ("12345€", "12345€"),
        ("123456€", "123456"),
        ("🦀🦀🦀", "🦀🦀"),
        ("ab\0cd", "ab"),
    ] {
        let text = Text::<8>::new(given);
        assert_eq!(text.as_str(), kept, "from {given:?}");
        assert_eq!(text.to_string(), kept);
    }
    assert_eq!(Text::<0>::new("anything").as_str(), "");
}

#[test]
fn bytes_that_are_not_text_read_as_empty() {
    for bytes in [
        [0xff; 4],
        [b'a', 0xc3, 0, 0],
        [b'a', b'b', 0xed, 0xa0],
        [0x80, 0, 0, 0],
    ] {
        assert_eq!(Text(bytes).as_str(), "", "{bytes:x?}");
    }
    // Bytes after the end of the text are ignored.
    assert_eq!(Text([b'a', 0, 0xff, 0xff]).as_str(), "a");
}

#[test]
fn equal_texts_have_equal_bytes() {
    assert_eq!(Text::<16>::new("lift"), Text::new("lift"));
    assert_eq!(Text::<16>::default(), Text::new(""));
    assert_eq!(
        format!(
            "{:?} [{:>6}]",
            Text::<16>::new("lift"),
            Text::<16>::new("lift")
        ),
        "\"lift\" [  lift]"
    );
}
