//! Protocol Buffers on the wire, <https://protobuf.dev/programming-guides/encoding/>: what is needed to write
//! a message, and the description of a type that is only known when it is written.
//!
//! Every field is written, also one that has its default value, so that readers which list what is there see
//! all of them.

/// A message, field by field. A field's number comes first, as its type has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Message(Vec<u8>);

impl Message {
    fn varint(&mut self, mut x: u64) {
        while x >= 0x80 {
            self.0.push(x as u8 | 0x80);
            x >>= 7;
        }
        self.0.push(x as u8);
    }

    fn key(&mut self, field: u32, wire: u64) {
        self.varint(u64::from(field) << 3 | wire);
    }

    /// A whole number, a choice or a truth value.
    pub(super) fn whole(mut self, field: u32, x: u64) -> Self {
        self.key(field, 0);
        self.varint(x);
        self
    }

    /// A number in eight bytes.
    pub(super) fn double(mut self, field: u32, x: f64) -> Self {
        self.key(field, 1);
        self.0.extend(x.to_le_bytes());
        self
    }

    /// A whole number in four bytes.
    pub(super) fn fixed32(mut self, field: u32, x: u32) -> Self {
        self.key(field, 5);
        self.0.extend(x.to_le_bytes());
        self
    }

    /// Bytes.
    pub(super) fn bytes(mut self, field: u32, bytes: &[u8]) -> Self {
        self.key(field, 2);
        self.varint(bytes.len() as u64);
        self.0.extend(bytes);
        self
    }

    /// A text.
    pub(super) fn text(self, field: u32, text: &str) -> Self {
        self.bytes(field, text.as_bytes())
    }

    /// A message in this one.
    pub(super) fn message(self, field: u32, message: &Self) -> Self {
        self.bytes(field, &message.0)
    }

    /// Messages in this one: a repeated field.
    pub(super) fn messages(self, field: u32, messages: impl IntoIterator<Item = Self>) -> Self {
        messages.into_iter().fold(self, |whole, message| whole.message(field, &message))
    }

    /// The message on the wire.
    pub(super) fn as_bytes(&self) -> &[u8] {
        &self.0
    }
}

/// Types of a described message's fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum FieldType {
    /// A number in eight bytes.
    Double,
    /// A text.
    Text,
}

/// The FileDescriptorSet of one message `package.name`, whose fields have the numbers 1, 2, ..
pub(super) fn described<'a>(
    package: &str,
    name: &str,
    fields: impl IntoIterator<Item = (&'a str, FieldType)>,
) -> Vec<u8> {
    const OPTIONAL: u64 = 1;
    let fields = (1..).zip(fields).map(|(number, (name, kind))| {
        let kind = match kind {
            FieldType::Double => 1,
            FieldType::Text => 9,
        };
        Message::default().text(1, name).whole(3, number).whole(4, OPTIONAL).whole(5, kind)
    });
    let message = Message::default().text(1, name).messages(2, fields);
    let file = Message::default()
        .text(1, &format!("{package}/{name}.proto"))
        .text(2, package)
        .message(4, &message)
        .text(12, "proto3");
    Message::default().message(1, &file).0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of "Encoding" in the documentation of Protocol Buffers.
    #[test]
    fn reference_messages_on_the_wire() {
        let whole = Message::default().whole(1, 150);
        assert_eq!(whole.as_bytes(), [0x08, 0x96, 0x01]);
        let text = Message::default().text(2, "testing");
        assert_eq!(text.as_bytes(), [&[0x12, 0x07][..], b"testing"].concat());
        let inner = Message::default().message(3, &whole);
        assert_eq!(inner.as_bytes(), [0x1A, 0x03, 0x08, 0x96, 0x01]);
        let double = Message::default().double(16, 1.0);
        assert_eq!(double.as_bytes(), [0x81, 0x01, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F]);
    }
}
