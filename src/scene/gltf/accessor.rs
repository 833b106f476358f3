//! The numbers of accessors (glTF 2.0, section 3.6.2), of whatever type they are stored in, with every index and length
//! checked: a file may say anything.

use ::gltf::accessor::{Accessor, DataType, sparse::IndexType};
use ::gltf::buffer::View;

/// More numbers than this no file holds that fits into memory.
const MOST: usize = 1 << 30;

/// The bytes of the file's buffers, by their numbers.
pub(super) type Buffers = [Vec<u8>];

/// The first `N` numbers of each element, normalised where the accessor is; why not, as the rest of a sentence.
pub(super) fn numbers<const N: usize>(
    accessor: &Accessor<'_>,
    buffers: &Buffers,
) -> Result<Vec<[f64; N]>, String> {
    let width = accessor.dimensions().multiplicity();
    if width < N {
        return Err(format!("has {width} numbers for an element, and {N} are needed"));
    }
    let kind = accessor.data_type();
    let size = size_of(kind);
    if accessor.count().checked_mul(N).is_none_or(|count| count > MOST) {
        return Err(format!("announces {} elements, which no file holds", accessor.count()));
    }
    let element = |bytes: &[u8]| -> [f64; N] {
        std::array::from_fn(|k| number(&bytes[k * size..(k + 1) * size], kind, accessor.normalized()))
    };
    let mut values = match accessor.view() {
        Some(view) => {
            let layout = Layout { offset: accessor.offset(), count: accessor.count(), size: width * size };
            layout.elements(&view, buffers)?.map(element).collect()
        }
        None if accessor.count() > buffers.iter().map(Vec::len).sum() => {
            return Err(format!("announces {} elements and has no data", accessor.count()));
        }
        // Zeros, but for the sparse ones.
        None => vec![[0.0; N]; accessor.count()],
    };
    if let Some(sparse) = accessor.sparse() {
        let (indices, replaced) = (sparse.indices(), sparse.values());
        let index_kind = match indices.index_type() {
            IndexType::U8 => DataType::U8,
            IndexType::U16 => DataType::U16,
            IndexType::U32 => DataType::U32,
        };
        let layout = |offset, size| Layout { offset, count: sparse.count(), size };
        let places = layout(indices.offset(), size_of(index_kind)).elements(&indices.view(), buffers)?;
        let news = layout(replaced.offset(), width * size).elements(&replaced.view(), buffers)?;
        for (place, bytes) in places.zip(news) {
            let place = number(place, index_kind, false) as usize;
            *values.get_mut(place).ok_or("replaces an element that it does not have")? = element(bytes);
        }
    }
    Ok(values)
}

/// Whole numbers; why not, as the rest of a sentence.
pub(super) fn indices(accessor: &Accessor<'_>, buffers: &Buffers) -> Result<Vec<u32>, String> {
    if !matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32) {
        return Err("has indices that are no whole numbers".to_owned());
    }
    Ok(numbers::<1>(accessor, buffers)?.into_iter().map(|[index]| index as u32).collect())
}

/// The bytes of a view; why not, as the rest of a sentence.
pub(super) fn bytes<'b>(view: &View<'_>, buffers: &'b Buffers) -> Result<&'b [u8], String> {
    let whole = || {
        let end = view.offset().checked_add(view.length())?;
        buffers.get(view.buffer().index())?.get(view.offset()..end)
    };
    whole().ok_or_else(|| "reaches beyond the end of its buffer".to_owned())
}

/// How elements lie in a view.
struct Layout {
    offset: usize,
    count: usize,
    /// Bytes of an element.
    size: usize,
}

impl Layout {
    fn elements<'b>(
        self,
        view: &View<'_>,
        buffers: &'b Buffers,
    ) -> Result<impl Iterator<Item = &'b [u8]> + use<'b>, String> {
        let Self { offset, count, size } = self;
        let stride = view.stride().unwrap_or(size).max(1);
        let last = count.checked_sub(1).map_or(Some(0), |steps| steps.checked_mul(stride)?.checked_add(size));
        let whole = bytes(view, buffers)?;
        let own = last.and_then(|length| whole.get(offset..offset.checked_add(length)?));
        let own = own.ok_or_else(|| format!("announces {count} elements, more than its data holds"))?;
        Ok((0..count).map(move |k| &own[k * stride..k * stride + size]))
    }
}

fn size_of(kind: DataType) -> usize {
    match kind {
        DataType::I8 | DataType::U8 => 1,
        DataType::I16 | DataType::U16 => 2,
        DataType::U32 | DataType::F32 => 4,
    }
}

/// A number of little-endian bytes, as many as its type has.
fn number(bytes: &[u8], kind: DataType, normalised: bool) -> f64 {
    let two = || [bytes[0], bytes[1]];
    let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
    let (value, top) = match kind {
        DataType::I8 => (f64::from(bytes[0] as i8), f64::from(i8::MAX)),
        DataType::U8 => (f64::from(bytes[0]), f64::from(u8::MAX)),
        DataType::I16 => (f64::from(i16::from_le_bytes(two())), f64::from(i16::MAX)),
        DataType::U16 => (f64::from(u16::from_le_bytes(two())), f64::from(u16::MAX)),
        DataType::U32 => (f64::from(u32::from_le_bytes(four())), f64::from(u32::MAX)),
        DataType::F32 => return f64::from(f32::from_le_bytes(four())),
    };
    if normalised { (value / top).max(-1.0) } else { value }
}
