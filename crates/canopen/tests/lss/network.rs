use canopen::lss::{self, BitRate};
use canopen::{Event, Frame, Node, Settings, State};
use object_dictionary::Object;
use units::{Duration, Instant};

use crate::{NM17X, REQUEST, RESPONSE, bytes, frame, full, id};

const VENDOR: Object<u32> = Object::new(0x1018, 1, "Vendor-ID").default(0xEC);
const PRODUCT: Object<u32> = Object::new(0x1018, 2, "Product code").default(0x71);
const REVISION: Object<u32> = Object::new(0x1018, 3, "Revision number").default(0x0001_0001);
const SERIAL: Object<u32> = Object::new(0x1018, 4, "Serial number");

object_dictionary::product! { pub(crate) VENDOR, PRODUCT, REVISION, SERIAL }

static SETTINGS: Settings = Settings { lss: Some(&NM17X), ..Settings::CIA_301 };

const NOW: Instant = Instant::ZERO;

/// A node that was started with its serial number, and has said so.
fn node() -> Node<LEN> {
    let mut node = Node::new(&DICTIONARY, id(0x7F), &SETTINGS);
    node.set_value(NOW, DICTIONARY.find(SERIAL.id()).unwrap(), 0x4D52_F567);
    node.boot(NOW);
    let _ = outputs(&mut node);
    node
}

fn outputs(node: &mut Node<LEN>) -> (Vec<Frame>, Vec<Event>) {
    let events = std::iter::from_fn(|| node.poll_event()).collect();
    (std::iter::from_fn(|| node.take_transmit()).collect(), events)
}

fn tell(node: &mut Node<LEN>, id: u16, hex: &str) -> (Vec<Frame>, Vec<Event>) {
    node.handle_frame(NOW, &frame(id, &bytes(hex)), &mut ());
    outputs(node)
}

fn answer(hex: &str) -> (Vec<Frame>, Vec<Event>) {
    (vec![frame(RESPONSE, &full(hex))], vec![])
}

/// NM17x ADDR-04, ADDR-11, LSS-01: V-LSSADR-01 to V-LSSADR-11 and the reset after, on a node.
#[test]
fn a_node_takes_its_node_id_in_every_state() {
    for command in ["02 00", "80 00", "01 00"] {
        let mut node = node();
        let _ = tell(&mut node, 0, command);
        for request in ["04 01", "40 EC 00 00 00", "41 71 00 00 00", "42 01 00 01 00"] {
            assert_eq!(tell(&mut node, REQUEST, request), (vec![], vec![]), "{command} {request}");
        }
        assert_eq!(tell(&mut node, REQUEST, "43 67 F5 52 4D 00 00 00"), answer("44"));
        assert_eq!(tell(&mut node, REQUEST, "11 25"), answer("11"));
        let event = lss::Event::Store { node_id: Some(id(0x25)), bit_rate: None };
        assert_eq!(tell(&mut node, REQUEST, "17 00"), (vec![], vec![Event::Lss(event)]));
        node.handle_lss_stored(Ok(()));
        assert_eq!(outputs(&mut node), answer("17"));
        assert_eq!(tell(&mut node, 0, "82 00"), (vec![], vec![Event::ResetCommunication]));
        assert_eq!((node.node_id(), node.pending_node_id()), (id(0x7F), Some(id(0x25))));
    }
}

/// NM17x ADDR-07 to ADDR-10: V-DEVADR-01 to V-DEVADR-08 and the reset at the end, on a node.
#[test]
fn a_node_shows_an_offer_and_takes_it_when_touched() {
    let mut node = node();
    let _ = tell(&mut node, 0, "02 00");
    for request in ["04 01", "40 EC 00 00 00", "41 FF FF FF FF", "42 FF FF FF FF", "43 FF FF FF FF"]
    {
        assert_eq!(tell(&mut node, REQUEST, request), (vec![], vec![]), "{request}");
    }
    node.take_offered_node_id();
    assert_eq!(outputs(&mut node), (vec![], vec![]), "nothing on offer yet");
    let offered = Event::Lss(lss::Event::Offered { node_id: id(2) });
    assert_eq!(tell(&mut node, REQUEST, "11 02 00 00 00 00 00 00"), (vec![], vec![offered]));
    node.take_offered_node_id();
    let taken = Event::Lss(lss::Event::StoreNodeId { node_id: id(2) });
    assert_eq!(outputs(&mut node), (vec![], vec![taken]));
    node.handle_lss_stored(Ok(()));
    assert_eq!(outputs(&mut node), answer("11"));
    let _ = tell(&mut node, REQUEST, "11 03");
    node.take_offered_node_id();
    let _ = outputs(&mut node);
    assert_eq!(tell(&mut node, 0, "81 00"), (vec![], vec![Event::ResetNode]));
    node.handle_lss_stored(Ok(()));
    node.take_offered_node_id();
    assert_eq!(outputs(&mut node), (vec![], vec![]), "silent after a reset");
}

/// NM17x LSS-07; decision A-26: the node is silent and deaf from the activation on.
#[test]
fn a_node_is_silent_once_the_bit_rate_changes() {
    let mut node = node();
    let _ = tell(&mut node, REQUEST, "04 01");
    let _ = tell(&mut node, REQUEST, "13 00 02");
    let (bit_rate, delay) = (BitRate::Kbit500, Duration::from_millis(10));
    let event = Event::Lss(lss::Event::ActivateBitTiming { bit_rate, delay });
    assert_eq!(tell(&mut node, REQUEST, "15 0A 00"), (vec![], vec![event]));
    assert_eq!(node.state(), State::Initialising);
    assert_eq!((tell(&mut node, REQUEST, "5E"), node.poll_timeout()), ((vec![], vec![]), None));
}

/// The filters let the requests through exactly where they are served.
#[test]
fn a_product_without_the_services_does_not_listen() {
    let with = node();
    let without = Node::<LEN>::new(&DICTIONARY, id(0x7F), &Settings::CIA_301);
    let listens = |node: &Node<LEN>| node.accepts().any(|accepted| accepted.id.get() == REQUEST);
    assert_eq!((listens(&with), listens(&without)), (true, false));
    let mut without = without;
    without.boot(NOW);
    let _ = outputs(&mut without);
    let _ = tell(&mut without, REQUEST, "04 01 00 00 00 00 00 00");
    assert_eq!(tell(&mut without, REQUEST, "5E 00 00 00 00 00 00 00"), (vec![], vec![]));
    assert_eq!(without.pending_node_id(), Some(id(0x7F)));
}
