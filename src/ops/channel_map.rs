//! Which channels the stored quads of a tensor hold.

/// For each stored channel of a tensor, which channel it is; `None` for padding to four.
/// The second input of a concat starts at a multiple of four, so padding can stand inside.
pub type ChannelMap = Vec<Option<usize>>;

/// The map of a tensor of `channels` channels that was not concatenated.
#[must_use]
pub fn channel_map(channels: usize) -> ChannelMap {
    (0..channels.next_multiple_of(4)).map(|c| (c < channels).then_some(c)).collect()
}
