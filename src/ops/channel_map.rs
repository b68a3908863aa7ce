//! The channels that the stored quads of a tensor hold.

/// For each stored channel, the tensor's channel it holds, or `None` for padding to a multiple of
/// four. The second input of a concat starts at a multiple of four, so padding can lie in the
/// middle.
pub type ChannelMap = Vec<Option<usize>>;

/// The map of a tensor with `channels` channels that is not a concatenation.
#[must_use]
pub fn channel_map(channels: usize) -> ChannelMap {
    (0..channels.next_multiple_of(4)).map(|c| (c < channels).then_some(c)).collect()
}
