//! Short queues of fixed size: samples and fixes between the filter's time and the present.

/// A queue of at most `SIZE` entries.
#[derive(Clone, Debug)]
pub struct Queue<T, const SIZE: usize> {
    entries: [Option<T>; SIZE],
    first: usize,
    length: usize,
}

impl<T: Copy, const SIZE: usize> Default for Queue<T, SIZE> {
    fn default() -> Self {
        Self { entries: [None; SIZE], first: 0, length: 0 }
    }
}

impl<T: Copy, const SIZE: usize> Queue<T, SIZE> {
    /// Whether nothing more goes in.
    pub fn is_full(&self) -> bool {
        self.length == SIZE
    }

    /// Puts an entry last; a full queue loses its oldest.
    pub fn push(&mut self, entry: T) {
        if self.is_full() {
            self.pop();
        }
        self.entries[(self.first + self.length) % SIZE] = Some(entry);
        self.length += 1;
    }

    /// The oldest entry.
    pub fn first(&self) -> Option<&T> {
        self.entries[self.first].as_ref()
    }

    /// Takes the oldest entry.
    pub fn pop(&mut self) -> Option<T> {
        let entry = self.entries[self.first].take()?;
        self.first = (self.first + 1) % SIZE;
        self.length -= 1;
        Some(entry)
    }

    /// All entries, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        (0..self.length).filter_map(|i| self.entries[(self.first + i) % SIZE].as_ref())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_a_full_queue_loses_its_oldest() {
        let mut queue = Queue::<u32, 3>::default();
        (1..=5).for_each(|i| queue.push(i));
        assert!(queue.is_full());
        assert_eq!(queue.iter().copied().collect::<Vec<_>>(), [3, 4, 5]);
        assert_eq!((queue.pop(), queue.first()), (Some(3), Some(&4)));
        queue.push(6);
        assert_eq!(queue.iter().copied().collect::<Vec<_>>(), [4, 5, 6]);
        while queue.pop().is_some() {}
        assert_eq!((queue.first(), queue.iter().count()), (None, 0));
    }
}
